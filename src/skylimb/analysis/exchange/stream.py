"""What passes between a run and a container: messages with a topic, a type and a time, one after another."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from skylimb.base.errors import OutputError, SkylimbError


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


@contextmanager
def readable(path: Path, kind: str) -> Iterator[None]:
    """Where a file is read: what a library raises for a damaged one is an `OutputError`.

    Raises:
        OutputError: also when there is no such file.
    """
    if not path.is_file():
        raise OutputError(f"log '{path}' {'is no regular file' if path.exists() else 'does not exist'}")
    try:
        yield
    except SkylimbError:
        raise
    except Exception as error:  # a damaged file fails in whatever layer meets the damage first
        first = (str(error).splitlines() or [type(error).__name__])[0]
        raise OutputError(f"'{path}' is not a readable {kind}: {first}") from error
