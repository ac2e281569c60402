"""MCAP with ROS 1 messages, which Foxglove, PlotJuggler and Rerun open."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from skylimb.analysis.exchange.message_types import message_types
from skylimb.analysis.exchange.stream import Message, readable
from skylimb.base.errors import extra_module
from skylimb.base.files import new_file


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
        """The messages of a file that are ROS 1's, read with the definitions that it brings."""
        reader_of = extra_module("mcap.reader").make_reader
        with readable(path, "MCAP file"), path.open("rb") as file:
            yield _messages(reader_of(file))


def _messages(reader: Any) -> Iterator[Message]:
    stores: dict[int, Any] = {}
    for schema, channel, message in reader.iter_messages():
        if schema is None or schema.encoding != "ros1msg":
            continue
        kind = schema.name if "/msg/" in schema.name else schema.name.replace("/", "/msg/", 1)
        if schema.id not in stores:
            stores[schema.id] = message_types({kind: schema.data.decode()})
        value = stores[schema.id].deserialize_ros1(message.data, kind)
        yield Message(channel.topic, kind, message.log_time, value)
