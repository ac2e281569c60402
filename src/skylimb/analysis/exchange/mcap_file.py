"""MCAP with ROS 1 messages, which Foxglove, PlotJuggler and Rerun open."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from skylimb.analysis.exchange.stream import Raw, whole
from skylimb.base.errors import extra_module
from skylimb.base.files import new_file, readable


class McapStream:
    """An MCAP file of the profile ros1 that grows message by message, in chunks with checksums.

    Args:
        path: of a new file.
        chunk: bytes after which a chunk is on its way to the disk, uncompressed; 0: an archive's, compressed.
    """

    def __init__(self, path: Path, chunk: int = 0) -> None:
        module = extra_module("mcap.writer")
        small = {"chunk_size": chunk, "compression": module.CompressionType.NONE} if chunk else {}
        self._file = path.open("xb")
        self._writer = module.Writer(self._file, **small)
        self._writer.start(profile="ros1", library="skylimb")
        self._schema, self._channel = cache(self._schema_of), cache(self._channel_of)

    def add(self, raw: Raw) -> None:
        """Write a message."""
        channel = self._channel(raw.topic, raw.type, raw.definition)
        self._writer.add_message(channel, raw.time, raw.content, raw.time)
        self._file.flush()

    def close(self) -> None:
        """Write the index, and end the file."""
        with self._file:
            self._writer.finish()

    def _schema_of(self, kind: str, definition: str) -> int:
        return self._writer.register_schema(kind.replace("/msg/", "/"), "ros1msg", definition.encode())

    def _channel_of(self, topic: str, kind: str, definition: str) -> int:
        return self._writer.register_channel(topic, "ros1", self._schema(kind, definition))


class Mcap:
    """An MCAP file of the profile ros1."""

    def write(self, path: Path, messages: Iterable[Raw]) -> None:
        """Write a new file."""
        with new_file(path) as aside, closing(McapStream(aside)) as stream:
            for message in messages:
                stream.add(message)

    @contextmanager
    def read(self, path: Path) -> Iterator[Iterator[Raw]]:
        """The messages of a file that are ROS 1's, with their own definitions; see `whole`."""
        reader_of = extra_module("mcap.reader").NonSeekingReader
        cut = extra_module("mcap.exceptions").EndOfFile
        with readable(path, "MCAP file") as file:
            yield whole(_raw(reader_of(file, validate_crcs=True)), path, cut)


def _raw(reader: Any) -> Iterator[Raw]:
    for schema, channel, message in reader.iter_messages(log_time_order=False):
        if schema is not None and schema.encoding == "ros1msg":
            kind = schema.name if "/msg/" in schema.name else schema.name.replace("/", "/msg/", 1)
            yield Raw(channel.topic, kind, schema.data.decode(), message.log_time, message.data)
