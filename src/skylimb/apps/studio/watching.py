"""The files of the user's that live flights were made from, looked at now and then."""

from __future__ import annotations

import os
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
        self._seen = {path: (_stamp(path), _digest(path)) for path in files}

    def changed(self) -> list[Path]:
        """The files whose content is another one than at the last call; a file that is gone is none of them.

        The content is read only of files whose time or size differs.
        """
        found = []
        for path, (stamp, digest) in self._seen.items():
            now = _stamp(path)
            if now is None or now == stamp:
                continue
            content = _digest(path)
            if content is None:
                continue
            self._seen[path] = (now, content)
            if content != digest:
                found.append(path)
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


def _stamp(path: Path) -> tuple[int, int] | None:
    try:
        found = os.stat(path)
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size


def _digest(path: Path) -> str | None:
    try:
        return read_source(path).digest
    except UnreadableError:
        return None
