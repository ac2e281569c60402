"""MCAP with ROS 1 messages, which Foxglove, PlotJuggler and Rerun open."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from skylimb.analysis.exchange.message_types import message_types
from skylimb.analysis.exchange.stream import Message, Raw, decoded
from skylimb.base.errors import extra_module
from skylimb.base.files import new_file, readable


class Mcap:
    """An MCAP file of the profile ros1."""

    def write(self, path: Path, messages: Iterable[Message]) -> None:
        """Write a new file."""
        types, writer_of = message_types(), extra_module("mcap.writer").Writer
        with new_file(path) as aside, aside.open("wb") as file:
            writer = writer_of(file)
            writer.start(profile="ros1", library="skylimb")

            @cache
            def schema(kind: str) -> int:
                text, _ = types.generate_msgdef(kind, ros_version=1)
                return writer.register_schema(kind.replace("/msg/", "/"), "ros1msg", text.encode())

            @cache
            def channel(topic: str, kind: str) -> int:
                return writer.register_channel(topic, "ros1", schema(kind))

            for message in messages:
                raw = bytes(types.serialize_ros1(message.value, message.type))
                writer.add_message(channel(message.topic, message.type), message.time, raw, message.time)
            writer.finish()

    @contextmanager
    def read(self, path: Path) -> Iterator[Iterator[Message]]:
        """The messages of a file that are ROS 1's, read with their own definitions; see `decoded`."""
        reader_of = extra_module("mcap.reader").NonSeekingReader
        cut = extra_module("mcap.exceptions").EndOfFile
        with readable(path, "MCAP file") as file:
            yield decoded(_raw(reader_of(file, validate_crcs=True)), path, cut)


def _raw(reader: Any) -> Iterator[Raw]:
    for schema, channel, message in reader.iter_messages(log_time_order=False):
        if schema is not None and schema.encoding == "ros1msg":
            kind = schema.name if "/msg/" in schema.name else schema.name.replace("/", "/msg/", 1)
            yield Raw(channel.topic, kind, schema.data.decode(), message.log_time, message.data)
