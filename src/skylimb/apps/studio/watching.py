"""The files of the user's that live flights were made from, looked at now and then."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from skylimb.base.errors import UnreadableError
from skylimb.base.sources import read_source
from skylimb.control.controller import Controller


class Watcher:
    """Tells which of some files have another content than before.

    Args:
        files: that are looked at.
    """

    def __init__(self, files: Iterable[Path]) -> None:
        self._seen = {path: _digest(path) for path in files}

    def changed(self) -> list[Path]:
        """The files with another content than at the last call; one that is gone is none of them."""
        now = {path: _digest(path) for path in self._seen}
        found = [path for path, digest in now.items() if digest not in (None, self._seen[path])]
        self._seen |= {path: now[path] for path in found}
        return found


def files_of_controller(given: str | Controller | None, controller: Controller) -> list[Path]:
    """Every file of the user's that a controller was made from.

    Args:
        given: as it was named.
        controller: that was made.
    """
    named = [Path(given)] if isinstance(given, str) and given.endswith((".py", ".toml")) else []
    slots: Sequence[Any] = getattr(getattr(controller, "preset", None), "slots", ())
    owners = (controller, *(slot.law for slot in slots))
    sources = [source for owner in owners for source in getattr(owner, "sources", ())]
    return list(dict.fromkeys([*named, *(source.path for source in sources if not source.shipped)]))


def _digest(path: Path) -> str | None:
    try:
        return read_source(path).digest
    except UnreadableError:
        return None
