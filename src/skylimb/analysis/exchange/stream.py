"""What passes between a run and a container: messages with a topic, a type and a time, one after another."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from skylimb.analysis.exchange.message_types import message_types
from skylimb.analysis.exchange.ros2_types import Ros2Types


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


def whole(messages: Iterable[Raw], path: Path, cut: type[Exception]) -> Iterator[Raw]:
    """Messages up to the last whole chunk of a file that was cut off.

    Args:
        messages: as they stand in the file.
        path: of the file.
        cut: raised by `messages` where the file ends too soon; that is told as a warning.
    """
    last = 0
    try:
        for message in messages:
            last = message.time
            yield message
    except cut:
        until = f"what was recorded up to {1e-9 * last:.3f} s" if last else "no message"
        warnings.warn(f"'{path}' was cut off: {until} is read", UserWarning, stacklevel=2)


def decoded(messages: Iterable[Raw]) -> Iterator[Message]:
    """Messages by the definitions of their file."""
    stores: dict[tuple[str, str], Any] = {}
    for topic, kind, definition, time, content, cdr in messages:
        if (kind, definition) not in stores:
            stores[kind, definition] = Ros2Types().types if cdr else message_types({kind: definition})
        types = stores[kind, definition]
        value = types.deserialize_cdr(content, kind) if cdr else types.deserialize_ros1(content, kind)
        yield Message(topic, kind, time, value)
