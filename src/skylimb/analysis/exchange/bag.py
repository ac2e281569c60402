"""ROS 1 bags, by rosbags: pure Python, chunks compressed with LZ4."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import cache, partial
from pathlib import Path

from skylimb.analysis.exchange.bag_records import raw_messages
from skylimb.analysis.exchange.message_types import message_types
from skylimb.analysis.exchange.stream import Message, decoded
from skylimb.base.files import new_file, readable


def _blocks(content: bytes) -> bytes:
    """LZ4 as ROS 1 itself reads it: blocks that need no other one, no size ahead of them, and a checksum."""
    from lz4.frame import compress

    return compress(content, 0, block_linked=False, store_size=False, content_checksum=True)


class Bag:
    """A ROS 1 bag."""

    def write(self, path: Path, messages: Iterable[Message]) -> None:
        """Write a new bag."""
        types = message_types()
        from rosbags.rosbag1 import Writer

        with new_file(path) as aside:
            writer = Writer(aside)
            writer.set_compression(Writer.CompressionFormat.LZ4)
            writer.compressor = _blocks
            with writer:
                connection = cache(partial(writer.add_connection, typestore=types))
                for message in messages:
                    raw = types.serialize_ros1(message.value, message.type)
                    writer.write(connection(message.topic, message.type), message.time, raw)

    @contextmanager
    def read(self, path: Path) -> Iterator[Iterator[Message]]:
        """The messages of a bag, read with the definitions that it brings; see `stream.decoded`."""
        with readable(path, "ROS 1 bag") as file:
            yield decoded(raw_messages(file), path, EOFError)
