"""ROS 1 bags, by rosbags: pure Python, chunks compressed with LZ4."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from skylimb.analysis.exchange.bag_records import raw_messages
from skylimb.analysis.exchange.message_types import message_types
from skylimb.analysis.exchange.stream import Raw, whole
from skylimb.base.errors import ConfigError
from skylimb.base.files import new_file, readable

if TYPE_CHECKING:
    from rosbags.interfaces import Connection


def _blocks(content: bytes) -> bytes:
    """LZ4 as ROS 1 itself reads it: blocks that need no other one, no size ahead of them, and a checksum."""
    from lz4.frame import compress

    return compress(content, 0, block_linked=False, store_size=False, content_checksum=True)


class Bag:
    """A ROS 1 bag."""

    def write(self, path: Path, messages: Iterable[Raw]) -> None:
        """Write a new bag."""
        from rosbags.rosbag1 import Writer

        with new_file(path) as aside:
            writer = Writer(aside)
            writer.set_compression(Writer.CompressionFormat.LZ4)
            writer.compressor = _blocks
            with writer:

                @cache
                def connection(topic: str, kind: str, definition: str) -> Connection:
                    types = message_types({kind: definition})
                    return writer.add_connection(topic, kind, typestore=types)

                for topic, kind, definition, time, content, cdr in messages:
                    if cdr:
                        raise ConfigError(f"'{path}': a bag holds messages of ROS 1 alone; write an .mcap")
                    writer.write(connection(topic, kind, definition), time, content)

    @contextmanager
    def read(self, path: Path, salvaged: bool = False) -> Iterator[Iterator[Raw]]:
        """The messages of a bag, with the definitions that it brings; see `stream.whole`."""
        with readable(path, "ROS 1 bag") as file:
            yield whole(raw_messages(file), file, path, salvaged)
