"""What passes between a run and a container: messages with a topic, a type and a time, one after another."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from skylimb.analysis.exchange.message_types import message_types


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
    """

    topic: str
    type: str
    definition: str
    time: int
    content: bytes


def decoded(messages: Iterable[Raw], path: Path, cut: type[Exception]) -> Iterator[Message]:
    """Messages by the definitions of their file, up to the last whole chunk of one that was cut off.

    Args:
        messages: as they stand in the file.
        path: of the file.
        cut: raised by `messages` where the file ends too soon; that is told as a warning.
    """
    stores: dict[tuple[str, str], Any] = {}
    last = 0
    try:
        for topic, kind, definition, last, content in messages:
            if (kind, definition) not in stores:
                stores[kind, definition] = message_types({kind: definition})
            yield Message(topic, kind, last, stores[kind, definition].deserialize_ros1(content, kind))
    except cut:
        until = f"what was recorded up to {1e-9 * last:.3f} s" if last else "no message"
        warnings.warn(f"'{path}' was cut off: {until} is read", UserWarning, stacklevel=2)
