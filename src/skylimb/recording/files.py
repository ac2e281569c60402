"""Writing aside, then renaming: what a reader finds under its final name is always whole.

Nothing here overwrites anything. A path that exists already is refused, at the start (`require_new`, to be
called before long work) and once more just before the renaming.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from skylimb.errors import OutputError


def require_new(path: str | Path) -> Path:
    """Check that `path` can be created, and leave nothing behind.

    Args:
        path: a file or folder that is going to be written; missing parents are fine, they are made later.

    Returns:
        The same path as a `Path`.

    Raises:
        OutputError: if something stands there already, a parent is not a folder, or the place cannot be
            written.
    """
    path = Path(path)
    try:
        if path.exists() or path.is_symlink():
            kind = "folder" if path.is_dir() else "file"
            raise OutputError(
                f"output {kind} '{path}' exists already; nothing is overwritten, choose another name"
            )
        parent = _nearest_existing(path.absolute().parent)
    except OSError as error:
        raise OutputError(f"cannot look at output '{path}': {error.strerror or error}") from error
    if not parent.is_dir():
        raise OutputError(f"cannot create '{path}': '{parent}' is a file, not a folder")
    # A folder that is made and removed again is the only sure sign: permissions say little of a read-only
    # file system.
    try:
        os.rmdir(tempfile.mkdtemp(prefix=".skylimb.", dir=parent))
    except OSError as error:
        raise OutputError(f"cannot create '{path}' in '{parent}': {error.strerror or error}") from error
    return path


@contextmanager
def new_file(path: str | Path) -> Iterator[Path]:
    """Yield a hidden sibling path to write to; it takes the name `path` when the block ends without an error.

    Raises:
        OutputError: if `path` exists or cannot be written.
    """
    path = require_new(path)
    with _aside(path) as staging:
        inside = staging / path.name
        yield inside
        _rename(inside, path)


@contextmanager
def new_folder(path: str | Path) -> Iterator[Path]:
    """Yield an empty hidden sibling folder; it takes the name `path` when the block ends without an error.

    On an error the staging folder and any parent made for it are removed, so that nothing is left behind.

    Raises:
        OutputError: if `path` exists or cannot be written.
    """
    path = require_new(path)
    with _aside(path) as staging:
        inside = staging / path.name
        inside.mkdir()
        yield inside
        _rename(inside, path)


@contextmanager
def _aside(path: Path) -> Iterator[Path]:
    """A staging folder beside `path`, on the same file system so that the renaming is one atomic step."""
    parent = path.absolute().parent
    made = [folder for folder in (parent, *parent.parents) if not folder.exists()]
    try:
        parent.mkdir(parents=True, exist_ok=True)
        staging = Path(tempfile.mkdtemp(prefix=f".{path.name}.", suffix=".partial", dir=parent))
    except OSError as error:
        raise OutputError(f"cannot create '{path}': {error.strerror or error}") from error
    try:
        yield staging
    finally:
        shutil.rmtree(staging, ignore_errors=True)
        for folder in made:
            with suppress(OSError):  # not empty: the result is in it
                folder.rmdir()


def _rename(source: Path, target: Path) -> None:
    require_new(target)
    try:
        source.rename(target)
    except OSError as error:
        raise OutputError(f"cannot create '{target}': {error.strerror or error}") from error


def _nearest_existing(folder: Path) -> Path:
    while not folder.exists():
        folder = folder.parent
    return folder
