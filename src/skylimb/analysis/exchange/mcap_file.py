"""MCAP with ROS 1 messages, which Foxglove, PlotJuggler and Rerun open."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from skylimb.analysis.exchange.message_types import message_types
from skylimb.analysis.exchange.stream import Message, readable
from skylimb.base.errors import missing_extra
from skylimb.base.files import new_file


def _mcap() -> Any:
    try:
        import mcap.reader
        import mcap.writer
    except ImportError:
        raise missing_extra("mcap") from None
    return mcap


class Mcap:
    """An MCAP file of the profile ros1."""

    def write(self, path: Path, messages: Iterable[Message]) -> None:
        """Write a new file."""
        mcap, types = _mcap(), message_types()
        with new_file(path) as aside, aside.open("wb") as file:
            writer = mcap.writer.Writer(file)
            writer.start(profile="ros1", library="skylimb")
            known: dict[str, int] = {}
            schemas: dict[str, int] = {}
            for message in messages:
                if message.topic not in known:
                    if message.type not in schemas:
                        text, _ = types.generate_msgdef(message.type, ros_version=1)
                        schemas[message.type] = writer.register_schema(
                            message.type.replace("/msg/", "/"), "ros1msg", text.encode()
                        )
                    known[message.topic] = writer.register_channel(
                        message.topic, "ros1", schemas[message.type]
                    )
                raw = bytes(types.serialize_ros1(message.value, message.type))
                writer.add_message(known[message.topic], message.time, raw, message.time)
            writer.finish()

    @contextmanager
    def read(self, path: Path) -> Iterator[Iterator[Message]]:
        """The messages of a file that are ROS 1's, read with the definitions that it brings."""
        mcap = _mcap()
        with readable(path, "MCAP file"), path.open("rb") as file:
            yield _messages(mcap.reader.make_reader(file))


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
