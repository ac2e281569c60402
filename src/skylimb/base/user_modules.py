"""A user's Python file as a module, and every file beside it that it imports, each read by `read_source`.

What is executed is the content that was read, never a compiled copy of it: a file that is edited twice within
a second is read twice. Imports of the file are sought in its own folder first, as Python does for a script.
"""

from __future__ import annotations

import functools
import importlib.abc
import importlib.util
import os
import sys
import sysconfig
import warnings
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import FrameType, ModuleType

from skylimb.base.errors import ConfigError, UnreadableError
from skylimb.base.sources import Source, read_source
from skylimb.base.user_code import UserCode, is_users

_INSTALLED = tuple(Path(sysconfig.get_path(name)) for name in ("purelib", "platlib", "stdlib"))


class _Loader(importlib.abc.SourceLoader):
    """Loads one file of a user's.

    Attributes:
        path: of the file.
        read: all files that were read for the user's module.
        opened: other files of the user's that its code has opened meanwhile.
    """

    def __init__(self, path: Path, read: list[Source]) -> None:
        self.path, self._source = path, None
        self.read = read
        self.opened: list[Path] = []

    def get_filename(self, fullname: str) -> str:
        return str(self.path)

    def get_data(self, path: str) -> bytes:  # type: ignore[override]
        if self._source is None:
            self._source = read_source(self.path)
            self.read.append(self._source)
        return self._source.content


class _Beside(importlib.abc.MetaPathFinder):
    """Finds the modules in one folder."""

    def __init__(self, folder: Path, read: list[Source]) -> None:
        self._folder, self._read = folder, read

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if _foreign(fullname):
            return None
        place = self._folder.joinpath(*fullname.split("."))
        for file, inside in (
            (place / "__init__.py", [str(place)]),
            (place.with_name(f"{place.name}.py"), None),
        ):
            if file.is_file():
                loader = _Loader(file, self._read)
                return importlib.util.spec_from_file_location(
                    fullname, file, loader=loader, submodule_search_locations=inside
                )
        return None


def load_module(path: Path, needed: tuple[str, ...]) -> ModuleType:
    """A user's Python file as a module, checked to define every name in `needed`.

    It is the same module as long as no file that was read for it has changed. Files beside it that it reads
    besides, such as tables of numbers, it names in `FILES`.

    Raises:
        ConfigError: when the file is missing, fails to import, or lacks a name.
    """
    named, path = path, path.resolve()
    name = _module_name(path)
    module = sys.modules.get(name)
    if module is None or not _unchanged(module):
        module = _executed(path, name)
    missing = [name for name in needed if not hasattr(module, name)]
    if missing:
        raise ConfigError(
            f"file '{named}' does not define {', '.join(missing)} (needed: {', '.join(needed)}); "
            "`skylimb examples` copies files to begin with"
        )
    return module


@contextmanager
def _same_folder(path: Path) -> Iterator[None]:
    """Set the working folder back where a user's file changes it, with a warning: paths begin in it."""
    before = Path.cwd()
    try:
        yield
    finally:
        if Path.cwd() != before:
            moved = Path.cwd()
            os.chdir(before)
            warnings.warn(
                f"'{path.name}' changes the working folder to '{moved}'; it is set back to '{before}', where "
                "paths begin. Files beside it are under Path(__file__).parent",
                UserWarning,
                stacklevel=2,
            )


def _unchanged(module: ModuleType) -> bool:
    """Whether every file that was read for a module still has the content that was read."""
    try:
        return all(read_source(source.path).content == source.content for source in sources_of_module(module))
    except UnreadableError:
        return False


def _executed(path: Path, name: str) -> ModuleType:
    if path.suffix != ".py":
        raise ConfigError(f"file '{path}' is not a Python module")
    if not path.is_file():
        raise ConfigError(f"file '{path}' does not exist")
    read: list[Source] = []
    loader = _Loader(path, read)
    module = importlib.util.module_from_spec(ModuleSpec(name, loader, origin=str(path)))
    module.__file__ = str(path)
    sys.modules[name] = module
    try:
        with UserCode(f"import of '{path.name}'"), _importing_beside(path.parent, read), _same_folder(path):
            with _noticing(loader.opened, (path.parent, Path.cwd())):
                loader.exec_module(module)
            read += [read_source(path.parent / name) for name in _named_files(module, path)]
    except BaseException:
        del sys.modules[name]
        raise
    return module


def _named_files(module: ModuleType, path: Path) -> Sequence[str]:
    """What a user's module names in `FILES`; a `ConfigError` where that is no list of names."""
    files = getattr(module, "FILES", ())
    if not isinstance(files, tuple | list) or not all(isinstance(name, str | os.PathLike) for name in files):
        raise ConfigError(
            f"'{path.name}': FILES = {files!r} should be a tuple of names, as in FILES = (\"table.csv\",)"
        )
    return files


def sources_of_module(module: object) -> tuple[Source, ...]:
    """Every file that was read for a user's module, its own first; none for other modules and objects."""
    loader = getattr(module, "__loader__", None)
    return tuple(loader.read) if isinstance(loader, _Loader) else ()


def unnamed_files(path: Path) -> list[str]:
    """What a user's file has opened as it was imported and `FILES` does not name: a sentence each.

    Args:
        path: of the file, absolute and without symbolic links.
    """
    loader = getattr(sys.modules.get(_module_name(path)), "__loader__", None)
    if not isinstance(loader, _Loader):
        return []
    known, home = {source.path for source in loader.read}, loader.path.parent
    said = []
    for opened in dict.fromkeys(loader.opened):
        if opened not in known:
            name = opened.relative_to(home).as_posix() if opened.is_relative_to(home) else opened.name
            said.append(
                f"'{loader.path.name}' opens '{name}', of which no copy is kept: put it beside, write "
                f'FILES = ("{name}",), and open Path(__file__).parent / "{name}"'
            )
    return said


_LISTENING: list[tuple[list[Path], tuple[Path, ...]]] = []
"""Where opened files are noted, and the folders in which they count; the last one counts."""


def _hear(event: str, given: tuple[object, ...]) -> None:
    if event != "open" or not _LISTENING or not isinstance(given[0], str | os.PathLike):
        return
    opened, folders = _LISTENING[-1]
    path = Path(given[0]).absolute()
    theirs = any(path.is_relative_to(folder) for folder in folders) and not _of_others(path)
    read = path.suffix not in (".py", ".pyc") and "w" not in str(given[1])
    if theirs and read and path.is_file() and _asked_by_them(sys._getframe(1)):
        opened.append(path.resolve())


def _asked_by_them(frame: FrameType | None) -> bool:
    """Whether a user's own line is behind a call, and not the import of another package."""
    while frame and not frame.f_code.co_filename.startswith("<frozen importlib"):
        if is_users(frame.f_code.co_filename):
            return True
        frame = frame.f_back
    return False


@functools.cache
def _hearing() -> None:
    sys.addaudithook(_hear)  # once: Python takes none back


@contextmanager
def _noticing(opened: list[Path], folders: tuple[Path, ...]) -> Iterator[None]:
    """Note the files in some folders that are opened inside of the block."""
    _hearing()
    _LISTENING.append((opened, folders))
    try:
        yield
    finally:
        _LISTENING.pop()


def _of_others(path: Path) -> bool:
    """Whether a file belongs to a cache, an environment or an installed package."""
    hidden = any(part.startswith(".") for part in path.parts)
    return hidden or any(path.is_relative_to(folder) for folder in _INSTALLED)


def _module_name(path: Path) -> str:
    """A name of its own among the loaded modules, where dataclasses look up what annotations mean."""
    return f"skylimb_user_{path.stem}_{zlib.crc32(str(path).encode()):08x}"


def _foreign(name: str) -> bool:
    """Whether a module is Python's or this package's, whatever lies in the user's folder."""
    top = name.partition(".")[0]
    return top in sys.stdlib_module_names or top == "skylimb"


@contextmanager
def _importing_beside(folder: Path, read: list[Source]) -> Iterator[None]:
    """Let imports find the files in `folder` first, and read them anew.

    A module of the same name that is loaded already may come from another folder, or be older than its file.
    It is put aside, and comes back afterwards unless it was loaded for a user's module as well.
    """
    names = {file.stem for file in folder.glob("*.py")} | {
        p.parent.name for p in folder.glob("*/__init__.py")
    }
    aside = {
        name: module
        for name, module in sys.modules.items()
        if name.partition(".")[0] in names and not _foreign(name) and not _installed(module)
    }
    for name in aside:
        del sys.modules[name]
    finder = _Beside(folder, read)
    sys.meta_path.insert(0, finder)
    try:
        yield
    finally:
        sys.meta_path.remove(finder)
        for name, module in aside.items():
            if name not in sys.modules or not isinstance(getattr(module, "__loader__", None), _Loader):
                sys.modules[name] = module


def _installed(module: ModuleType) -> bool:
    file = getattr(module, "__file__", None)
    return file is None or any(Path(file).is_relative_to(folder) for folder in _INSTALLED)
