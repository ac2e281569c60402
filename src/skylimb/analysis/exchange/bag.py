"""ROS 1 bags, by rosbags: pure Python, chunks compressed with LZ4."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from skylimb.analysis.exchange.message_types import message_types
from skylimb.analysis.exchange.stream import Message, readable
from skylimb.base.files import new_file


class Bag:
    """A ROS 1 bag."""

    def write(self, path: Path, messages: Iterable[Message]) -> None:
        """Write a new bag."""
        types = message_types()
        from rosbags.rosbag1 import Writer

        with new_file(path) as aside:
            writer = Writer(aside)
            writer.set_compression(Writer.CompressionFormat.LZ4)
            with writer:
                known = {}
                for message in messages:
                    if message.topic not in known:
                        known[message.topic] = writer.add_connection(
                            message.topic, message.type, typestore=types
                        )
                    raw = types.serialize_ros1(message.value, message.type)
                    writer.write(known[message.topic], message.time, raw)

    @contextmanager
    def read(self, path: Path) -> Iterator[Iterator[Message]]:
        """The messages of a bag, read with the definitions that it brings."""
        message_types()
        from rosbags.highlevel import AnyReader

        with readable(path, "ROS 1 bag"), AnyReader([path]) as reader:
            yield (
                Message(one.topic, one.msgtype, time, reader.deserialize(raw, one.msgtype))
                for one, time, raw in reader.messages()
            )
