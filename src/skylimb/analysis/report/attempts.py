"""What comes after a flight may fail part by part; the other parts are made all the same."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from skylimb.base.files import replace_text
from skylimb.base.user_code import described

FAILED_FILE = "failed.txt"
"""In a folder of runs: what could not be made, a line each; not there where all was."""

_log = logging.getLogger(__name__)


class Attempts:
    """Parts that are made one after the other.

    Attributes:
        failed: what could not be made and why, by the part's name.
    """

    def __init__(self) -> None:
        self.failed: dict[str, str] = {}

    @contextmanager
    def part(self, name: str) -> Iterator[None]:
        """Make a part of that name in the block; an error in it is noted."""
        try:
            yield
        except Exception as error:
            _log.debug("%s failed", name, exc_info=error)
            self.failed[name] = (isinstance(error, OSError) and error.strerror) or described(error)

    def lines(self) -> tuple[str, ...]:
        """A line for each part that failed."""
        return tuple(
            why if why.startswith(name) else f"{name} failed: {why}" for name, why in self.failed.items()
        )


def mark_failed(folder: Path, lines: Iterable[str]) -> None:
    """Leave in a folder what could not be made there, or nothing where all was.

    Raises:
        OSError: when the folder cannot be written.
    """
    text = "".join(f"{line}\n" for line in lines)
    if text:
        replace_text(folder / FAILED_FILE, text)
    else:
        (folder / FAILED_FILE).unlink(missing_ok=True)


def mark_more_failed(folder: Path, lines: Iterable[str]) -> None:
    """Add to what could not be made in a folder; see `mark_failed`."""
    mark_failed(folder, (*marked_failed(folder), *lines))


def marked_failed(folder: Path) -> list[str]:
    """What could not be made in a folder of runs, a line each."""
    file = folder / FAILED_FILE
    return file.read_text("utf-8", "replace").splitlines() if file.is_file() else []
