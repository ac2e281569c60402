"""Writing aside, then renaming: what a reader finds under its final name is always whole.

`new_file` and `new_folder` overwrite nothing. A path that exists already is refused, at the start
(`require_new`, to be called before long work) and once more just before the renaming. `replacing` is for a
file that may be there already: a reader sees the old one or the new one.
"""

from __future__ import annotations

import csv
import io
import itertools
import os
import platform
import re
import secrets
import shutil
import sys
import tempfile
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

from skylimb.base.errors import OutputError, SkylimbError, first_line


@contextmanager
def readable(source: Path | BinaryIO, kind: str, called: str = "") -> Iterator[BinaryIO]:
    """A file that a library reads: what that raises for a damaged one is an `OutputError`.

    Args:
        source: its path, or its bytes as a stream.
        kind: of file, for messages.
        called: what messages call it; its path by default.

    Raises:
        OutputError: also when there is no such file.
    """
    called = called or str(source)
    try:
        if isinstance(source, Path) and source.exists() and not source.is_file():
            raise OutputError(f"cannot read '{called}': it is no regular file")
        opened = source.open("rb") if isinstance(source, Path) else source
    except FileNotFoundError:
        raise OutputError(f"'{called}' does not exist") from None
    except OSError as error:
        raise OutputError(f"cannot read '{called}': {error.strerror or error}") from error
    with opened:
        try:
            yield opened
        except SkylimbError:
            raise
        except Exception as error:  # a damaged file fails in whatever layer meets the damage first
            raise OutputError(f"'{called}' is not a readable {kind}: {first_line(error)}") from error


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
    except OSError as error:
        raise OutputError(f"cannot look at output '{path}': {error.strerror or error}") from error
    require_room(path)
    return path


def require_room(path: Path) -> None:
    """Check that something can be written beside `path`, and leave nothing behind.

    Raises:
        OutputError: if a parent is not a folder, or the place cannot be written.
    """
    try:
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


def csv_text(rows: Iterable[Iterable[Any]]) -> str:
    """Rows as CSV, a line each."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


@contextmanager
def new_file(path: str | Path) -> Iterator[Path]:
    """Yield a hidden sibling path to write to; it takes the name `path` when the block ends without an error.

    Raises:
        OutputError: if `path` exists or cannot be written; nothing is left behind then, on a full disk too.
    """
    path = require_new(path)
    with writing(path), staging(path) as aside:
        inside = aside / path.name
        yield inside
        rename_new(inside, path)


@contextmanager
def new_folder(path: str | Path) -> Iterator[Path]:
    """Yield an empty hidden sibling folder; it takes the name `path` when the block ends without an error.

    On an error the staging folder and any parent made for it are removed, so that nothing is left behind.

    Raises:
        OutputError: if `path` exists or cannot be written.
    """
    with new_file(path) as inside:
        inside.mkdir()
        yield inside


@contextmanager
def replacing(path: str | Path, durable: bool = True) -> Iterator[Path]:
    """Yield a hidden sibling path; when the block ends without an error it takes the place of `path`.

    Args:
        path: a file that may be there.
        durable: whether the content has to be on the disk before the name changes, so that a power cut leaves
            no half file either. What can be made again does not need that.

    Raises:
        OSError: if it cannot be written; what stood there before stands there still.
    """
    path = Path(path)
    aside = _aside(path)
    try:
        yield aside
        if durable:
            with aside.open("rb+") as file:
                os.fsync(file.fileno())
        os.replace(aside, path)
    finally:
        aside.unlink(missing_ok=True)


def replace_text(path: str | Path, text: str) -> None:
    """Write a text file, in the place of one that may be there.

    Raises:
        OSError: if it cannot be written; what stood there before stands there still.
    """
    with replacing(path) as aside:
        aside.write_text(text, encoding="utf-8")


@contextmanager
def writing(path: str | Path) -> Iterator[None]:
    """Turn the system's complaint into one line that names the path.

    Raises:
        OutputError: for every OSError within.
    """
    try:
        yield
    except OSError as error:
        raise OutputError(f"cannot write '{path}': {error.strerror or error}") from error


@contextmanager
def staging(path: Path, left: Collection[Path] = ()) -> Iterator[Path]:
    """A staging folder beside `path`, on the same file system so that the renaming is one atomic step.

    It is removed at the end, with what was not renamed; not while `left` names something that stays in it.

    Raises:
        OutputError: if it cannot be made.
    """
    require_room(path)
    parent = path.absolute().parent
    made = [folder for folder in (parent, *parent.parents) if not folder.exists()]
    aside = _aside(path.absolute())
    try:
        with writing(path):
            parent.mkdir(parents=True, exist_ok=True)
            aside.mkdir(mode=0o700)
        yield aside
    finally:
        if not left:
            shutil.rmtree(aside, ignore_errors=True)
        for folder in made:
            with suppress(OSError):  # not empty: the result is in it
                folder.rmdir()


def rename_new(source: Path, target: Path) -> None:
    """Give what was written aside its name, unless something has it already."""
    require_new(target)
    source.rename(target)


def first_free(folder: Path, name: str) -> Path:
    """The first path in a folder that is not there yet; a number stands for the braces in its name."""
    paths = (folder / name.format(number) for number in itertools.count(1))
    return next(path for path in paths if not path.exists())


def interrupted_name(folder: Path) -> Path:
    """A free name for a folder whose flights were not all flown: FOLDER-interrupted, or with a number."""
    place = Path(f"{folder}-interrupted")
    return first_free(place.parent, f"{place.name}-{{}}") if place.exists() else place


def _aside(path: Path) -> Path:
    """A hidden name beside `path` of its own: two processes may write the same file at once.

    It names machine and process, so that what a killed one left is known for it (`orphans`).
    """
    return path.with_name(f".{path.name}.{_machine()}-{os.getpid()}-{secrets.token_hex(4)}.partial")


_ASIDE = re.compile(r"\.(?P<name>.+)\.(?P<machine>[^.]*)-(?P<process>\d+)-[0-9a-f]{8}\.partial")


def orphans(folder: Path) -> list[tuple[Path, str]]:
    """What was written aside at or below a folder by processes of this machine that are no more.

    Returns:
        Path, and the name that it was to have; the deeper ones of those that lie in another are left out.
    """
    found: list[tuple[Path, str]] = []
    for place, folders, files in os.walk(folder):
        for name in (*folders, *files):
            known = _ASIDE.fullmatch(name)
            if known and known["machine"] == _machine() and not _runs(int(known["process"])):
                found.append((Path(place, name), known["name"]))
        folders[:] = [name for name in folders if not _ASIDE.fullmatch(name)]
    return sorted(found)


def _machine() -> str:
    return re.sub(r"[^\w-]", "_", platform.node())[:32]


def _runs(process: int) -> bool:
    """Whether a process of this machine is still there, or may be."""
    if sys.platform == "win32":  # asking would end it there
        return True
    try:
        os.kill(process, 0)
    except OSError as error:  # another user's is there, and may not be asked
        return not isinstance(error, ProcessLookupError)
    return True


def _nearest_existing(folder: Path) -> Path:
    while not folder.exists():
        folder = folder.parent
    return folder
