"""Writing into a folder that others may read at any time, by one process at a time."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from skylimb.errors import OutputError

SPEC_FILE = "spec.toml"
"""The spec with everything that it resolved to: in every folder, and what is locked."""


def write_texts(folder: Path, texts: dict[str, str]) -> None:
    """Write files aside and rename them, what is there being replaced.

    Args:
        folder: where.
        texts: file name -> content.
    """
    for name, text in texts.items():
        with replacing(folder / name) as aside:
            aside.write_text(text, encoding="utf-8")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A place aside that takes the name of `path`, whatever is there, when it is complete and on the disk."""
    aside = path.with_name(f".{path.name}.partial")
    aside.unlink(missing_ok=True)
    try:
        yield aside
        with aside.open("rb") as file:
            os.fsync(file.fileno())
        os.replace(aside, path)
    finally:
        aside.unlink(missing_ok=True)


@contextmanager
def full_disk(folder: Path) -> Iterator[None]:
    """Turn the system's complaint into one that says what is kept.

    Raises:
        OutputError: for every OSError within.
    """
    try:
        yield
    except OSError as error:
        what = (
            "the disk is full"
            if error.errno in (errno.ENOSPC, errno.EDQUOT)
            else (error.strerror or str(error))
        )
        raise OutputError(
            f"cannot write to '{folder}': {what}; what was flown is kept there, and --resume goes on"
        ) from error


def lock(folder: Path) -> IO[bytes]:
    """The spec, locked against other processes while this one lives; the system lets go of it at the end.

    Raises:
        OutputError: when another process has it, or the folder cannot be written.
    """
    try:
        file = (folder / SPEC_FILE).open("ab")
    except OSError as error:
        raise OutputError(f"cannot write to '{folder}': {error.strerror or error}") from error
    try:
        if sys.platform == "win32":
            import msvcrt

            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        file.close()
        raise OutputError(f"campaign folder '{folder}' is in use by another process") from None
    return file
