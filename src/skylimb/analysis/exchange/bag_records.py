"""The messages of a ROS 1 bag in the order of its records, which a bag that was cut off has as well.

A bag's index comes last, so a recording that was killed has none, and readers that begin with it see nothing.
What is read here are chunks one after another, each whole or not at all.
"""

from __future__ import annotations

import bz2
import io
import struct
from collections.abc import Callable, Iterable, Iterator
from typing import BinaryIO

from skylimb.analysis.exchange.stream import Raw
from skylimb.base.errors import extra_module

_MAGIC = b"#ROSBAG V2.0\n"
_MESSAGE, _CHUNK, _CONNECTION = 2, 5, 7


def raw_messages(file: BinaryIO) -> Iterator[Raw]:
    """Every message up to the end.

    Raises:
        EOFError: in the middle of a record.
        ValueError: when it is no bag.
    """
    if file.read(len(_MAGIC)) != _MAGIC:
        raise ValueError(f"it does not begin with {_MAGIC.decode().strip()}")
    known: dict[bytes, tuple[str, str, str]] = {}
    for fields, content in _records(file):
        inside = fields[b"op"][0] == _CHUNK
        if inside and fields[b"compression"] == b"none":
            _require_more(file)
        records = _records(io.BytesIO(_unpacked(fields, content))) if inside else ((fields, content),)
        yield from list(_messages(records, known))


def _require_more(file: BinaryIO) -> None:
    """A chunk that is not compressed has no checksum: zeros behind it may have begun within it.

    Raises:
        ValueError: when zeros follow.
    """
    size = file.read(4)
    file.seek(-len(size), io.SEEK_CUR)
    if size and not any(size):
        raise ValueError("zeros follow a chunk")


def _messages(
    records: Iterable[tuple[dict[bytes, bytes], bytes]], known: dict[bytes, tuple[str, str, str]]
) -> Iterator[Raw]:
    """The messages among records; `known` takes the topic, the type and the definition of each connection."""
    for of, data in records:
        if of[b"op"][0] == _CONNECTION:
            said = _fields(data)
            kind = said[b"type"].decode().replace("/", "/msg/", 1)
            known[of[b"conn"]] = of[b"topic"].decode(), kind, said[b"message_definition"].decode()
        elif of[b"op"][0] == _MESSAGE:
            seconds, rest = struct.unpack("<II", of[b"time"])
            yield Raw(*known[of[b"conn"]], seconds * 10**9 + rest, data)


def _unpacked(fields: dict[bytes, bytes], content: bytes) -> bytes:
    ways: dict[bytes, Callable[[bytes], bytes]] = {
        b"none": bytes,
        b"bz2": bz2.decompress,
        b"lz4": extra_module("lz4.frame").decompress,
    }
    return ways[fields[b"compression"]](content)


def _records(file: BinaryIO) -> Iterator[tuple[dict[bytes, bytes], bytes]]:
    """Header and data of each record."""
    while size := file.read(4):
        yield _fields(_part(file, size)), _part(file, file.read(4))


def _part(file: BinaryIO, size: bytes) -> bytes:
    """What follows its size."""
    length = struct.unpack("<I", size)[0] if len(size) == 4 else -1
    content = file.read(max(length, 0))
    if len(content) != length:
        raise EOFError
    return content


def _fields(header: bytes) -> dict[bytes, bytes]:
    """The fields of a header by name."""
    found, parts = dict[bytes, bytes](), io.BytesIO(header)
    while size := parts.read(4):
        name, _, value = _part(parts, size).partition(b"=")
        found[name] = value
    return found
