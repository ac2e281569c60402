"""What passes between a run and a container: messages with a topic, a type and a time, one after another."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from skylimb.analysis.exchange.message_types import message_types
from skylimb.analysis.exchange.ros2_types import Ros2Types
from skylimb.base.errors import first_line

_BLOCK = 65_536
"""Bytes that are looked at together."""


class Message(NamedTuple):
    """A message.

    Attributes:
        topic: with its namespace.
        type: "geometry_msgs/msg/PoseStamped".
        time: when it was recorded, ns.
        value: an object of that type's class.
    """

    topic: str
    type: str
    time: int
    value: Any


class Raw(NamedTuple):
    """A message as a file holds it.

    Attributes:
        topic: with its namespace.
        type: "geometry_msgs/msg/PoseStamped".
        definition: of the type, as the file brings it.
        time: when it was recorded, ns.
        content: serialized.
        cdr: whether as ROS 2 does.
    """

    topic: str
    type: str
    definition: str
    time: int
    content: bytes
    cdr: bool = False


def encoder(ros2: bool = False) -> Callable[[Message], Raw]:
    """What makes a message as a file holds it, by ROS 1's definitions and the lab's, or by those of ROS 2."""
    types = Ros2Types().types if ros2 else message_types()
    definition = cache(lambda kind: types.generate_msgdef(kind, ros_version=2 if ros2 else 1)[0])
    serialize = types.serialize_cdr if ros2 else types.serialize_ros1

    def encode(message: Message) -> Raw:
        content = bytes(serialize(message.value, message.type))
        return Raw(message.topic, message.type, definition(message.type), message.time, content, ros2)

    return encode


def whole(messages: Iterable[Raw], file: BinaryIO, path: Path, salvaged: bool) -> Iterator[Raw]:
    """Messages up to the last whole chunk of a file that was cut off; a warning says that it was.

    A file is cut off where it cannot be read on and nothing stands behind but zeros: after a loss of power a
    file has its length, and zeros in place of what was not yet on the disk. Anything else is damage.

    Args:
        messages: as they stand in the file; each error is raised where the file was read up to.
        file: that they are read from, one after another.
        path: of the file.
        salvaged: whether what lies before damage is wanted as well; else the file is refused.
    """
    last = 0
    try:
        for message in messages:
            last = message.time
            yield message
    except Exception as error:  # a library meets a cut in whatever layer it stands in
        cut = _only_zeros_follow(file)
        if not (cut or (salvaged and last)):
            raise
        until = f"what was recorded up to {1e-9 * last:.3f} s" if last else "no message"
        what = "was cut off" if cut else f"is damaged ({first_line(error)})"
        warnings.warn(f"'{path}' {what}: {until} is read", UserWarning, stacklevel=2)


def _only_zeros_follow(file: BinaryIO) -> bool:
    """Whether a file has nothing but zeros from here on, or ends here."""
    try:
        return not any(block.strip(b"\0") for block in iter(lambda: file.read(_BLOCK), b""))
    except OSError:  # the disk does not give it
        return False


def decoded(messages: Iterable[Raw]) -> Iterator[Message]:
    """Messages by the definitions of their file."""
    stores: dict[tuple[str, str], Any] = {}
    for topic, kind, definition, time, content, cdr in messages:
        if (kind, definition) not in stores:
            stores[kind, definition] = Ros2Types().types if cdr else message_types({kind: definition})
        types = stores[kind, definition]
        value = types.deserialize_cdr(content, kind) if cdr else types.deserialize_ros1(content, kind)
        yield Message(topic, kind, time, value)
