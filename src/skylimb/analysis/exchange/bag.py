"""ROS 1 bags, by rosbags: pure Python, chunks compressed with LZ4."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import cache, partial
from pathlib import Path

from skylimb.analysis.exchange.message_types import message_types
from skylimb.analysis.exchange.stream import Message, readable
from skylimb.base.errors import extra_module
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
                connection = cache(partial(writer.add_connection, typestore=types))
                for message in messages:
                    raw = types.serialize_ros1(message.value, message.type)
                    writer.write(connection(message.topic, message.type), message.time, raw)

    @contextmanager
    def read(self, path: Path) -> Iterator[Iterator[Message]]:
        """The messages of a bag, read with the definitions that it brings."""
        reader_of = extra_module("rosbags.highlevel").AnyReader
        with readable(path, "ROS 1 bag"), reader_of([path]) as reader:
            yield (
                Message(one.topic, one.msgtype, time, reader.deserialize(raw, one.msgtype))
                for one, time, raw in reader.messages()
            )
