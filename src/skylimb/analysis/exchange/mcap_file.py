"""MCAP with messages of ROS 1 or ROS 2, which Foxglove, PlotJuggler and Rerun open."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager
from functools import cache
from itertools import chain
from pathlib import Path
from typing import Any

from skylimb.analysis.exchange.stream import Raw, whole
from skylimb.base.errors import extra_module
from skylimb.base.files import new_file, readable


class McapStream:
    """An MCAP file that grows message by message, in chunks with checksums.

    Args:
        path: of a new file.
        chunk: bytes after which a chunk is on its way to the disk, uncompressed; 0: an archive's, compressed.
        ros2: whether it holds messages of ROS 2, as `ros2 bag` reads them.
    """

    def __init__(self, path: Path, chunk: int = 0, ros2: bool = False) -> None:
        module = extra_module("mcap.writer")
        small = {"chunk_size": chunk, "compression": module.CompressionType.NONE} if chunk else {}
        self._file = path.open("xb")
        self._writer = module.Writer(self._file, **small)
        self._ros2, self._gap = ros2, False
        self._writer.start(profile="ros2" if ros2 else "ros1", library="skylimb")
        self._schema, self._channel = cache(self._schema_of), cache(self._channel_of)

    def add(self, raw: Raw) -> None:
        """Write a message."""
        self._gap = True
        channel = self._channel(raw.topic, raw.type, raw.definition)
        self._writer.add_message(channel, raw.time, raw.content, raw.time)
        self._file.flush()
        self._gap = False

    def close(self) -> None:
        """End the file, with an index; without one after a message that was not written, as if cut off there.

        Raises:
            OSError: when that cannot be written; the file is closed nevertheless.
        """
        with self._file:
            if not self._gap:
                self._writer.finish()

    def _schema_of(self, kind: str, definition: str) -> int:
        name, text = (kind, "ros2msg") if self._ros2 else (kind.replace("/msg/", "/"), "ros1msg")
        return self._writer.register_schema(name, text, definition.encode())

    def _channel_of(self, topic: str, kind: str, definition: str) -> int:
        encoding = "cdr" if self._ros2 else "ros1"
        return self._writer.register_channel(topic, encoding, self._schema(kind, definition))


class Mcap:
    """An MCAP file of the profile ros1 or ros2."""

    def write(self, path: Path, messages: Iterable[Raw]) -> None:
        """Write a new file, of the profile that its first message is of."""
        messages = iter(messages)
        first = next(messages, None)
        some = () if first is None else (first,)
        ros2 = first is not None and first.cdr
        with new_file(path) as aside, closing(McapStream(aside, ros2=ros2)) as stream:
            for message in chain(some, messages):
                stream.add(message)

    @contextmanager
    def read(self, path: Path, salvaged: bool = False) -> Iterator[Iterator[Raw]]:
        """The messages of a file that are ROS's, with their own definitions; see `whole`."""
        reader_of = extra_module("mcap.reader").NonSeekingReader
        with readable(path, "MCAP file") as file:
            yield whole(_raw(reader_of(file, validate_crcs=True)), file, path, salvaged)


def _raw(reader: Any) -> Iterator[Raw]:
    for schema, channel, message in reader.iter_messages(log_time_order=False):
        if schema is not None and schema.encoding in ("ros1msg", "ros2msg"):
            kind = schema.name if "/msg/" in schema.name else schema.name.replace("/", "/msg/", 1)
            cdr = schema.encoding == "ros2msg"
            yield Raw(channel.topic, kind, schema.data.decode(), message.log_time, message.data, cdr)
