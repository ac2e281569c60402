"""What passes between a run and a container: messages with a topic, a type and a time, one after another."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from skylimb.base.errors import OutputError, choice_error

ENDINGS = (".nc", ".bag", ".mcap")


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


class Container(Protocol):
    """A file format that holds messages."""

    def write(self, path: Path, messages: Iterable[Message]) -> None:
        """Write a new file; messages are taken one by one, in the order of their time."""
        ...

    def read(self, path: Path) -> AbstractContextManager[Iterator[Message]]:
        """The messages of a file in the order of their time, one by one."""
        ...


def container_of(path: str | Path) -> Container:
    """The container that a file's ending names.

    Raises:
        ConfigError: for an ending that is none of a log.
        MissingExtraError: without the extra `logs`.
    """
    ending = Path(path).suffix
    if ending == ".bag":
        from skylimb.analysis.exchange.bag import Bag

        return Bag()
    if ending == ".mcap":
        from skylimb.analysis.exchange.mcap_file import Mcap

        return Mcap()
    raise choice_error("ending of a log", ending or str(path), ENDINGS)


def unreadable(path: Path, kind: str, error: Exception) -> OutputError:
    """The error for a file that a library cannot read."""
    first = (str(error).splitlines() or [type(error).__name__])[0]
    return OutputError(f"'{path}' is not a readable {kind}: {first}")


def require_file(path: Path) -> None:
    """Raise an `OutputError` unless there is such a file."""
    if not path.is_file():
        raise OutputError(f"log '{path}' {'is a folder' if path.exists() else 'does not exist'}")
