"""C code compiled once, with the machine's compiler, into the user's cache under its digest."""

from __future__ import annotations

import atexit
import contextlib
import ctypes
import functools
import hashlib
import os
import platform
import shutil
import signal
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path

from skylimb.base.cache import cache_folder, keep, kept
from skylimb.base.errors import CompileError

# The engine's own binaries ask for AVX on these machines; with it, code is a seventh shorter.
_WIDE = ("-mavx",) if platform.machine().lower() in ("x86_64", "amd64") else ()

FLAGS = ("-O2", "-ffp-contract=off", "-fno-math-errno", *_WIDE, "-shared", "-fPIC")
"""No fused multiply-add and no reordering, so that every machine computes the same numbers."""

_PATIENCE = 600.0
"""How long a compiler may take, s: a supervised tick takes 20 s alone, and minutes on a busy machine."""


def built_library(folder: str, stem: str, source: str) -> Path:
    """Path of the shared library made of a C source; built where the cache has none for this machine.

    Where the cache cannot be written, the library is built in a temporary folder and serves this process.

    Args:
        folder: below the user's cache.
        stem: how the library's name begins.
        source: the C code; it may include the engine's headers, and links to libm alone.

    Raises:
        CompileError: when no compiler is found or none accepts the source.
    """
    library, cache = _library_name(folder, stem, source), cache_folder()
    try:
        return _built_below(cache, library, source)
    # A compiler on a full disk fails as it does over a wrong source, so both are tried elsewhere.
    except (OSError, CompileError) as error:
        problems = [error]
    for parent in _temporary_folders():
        try:
            built = _built_below(_process_folder(parent, os.getpid()), library, source)
        except (OSError, CompileError) as error:
            problems.append(error)
            continue
        _warn_once(cache, problems[0])
        return built
    for problem in problems:
        if isinstance(problem, CompileError):
            raise problem
    raise CompileError(f"C code can be compiled nowhere: {'; '.join(map(str, problems))}")


def met_often(folder: str, stem: str, source: str, often: int) -> bool:
    """Whether this machine's cache has the library of a C source, or was asked for it `often` times before.

    A library pays only after some flights. So whoever flies once asks this first. Where the cache cannot be
    written the answer stays no.
    """
    path = cache_folder() / _library_name(folder, stem, source)
    if path.is_file():
        return True
    if path.is_absolute():
        mark = path.with_suffix(".met")  # a byte for each time
        with contextlib.suppress(OSError):
            mark.parent.mkdir(parents=True, exist_ok=True)
            with mark.open("ab") as file:
                return file.write(b".") + mark.stat().st_size > often
    return False


def built_before(folder: str, stem: str, source: str) -> bool:
    """Whether this machine's cache has the library of a C source."""
    return (cache_folder() / _library_name(folder, stem, source)).is_file()


def _library_name(folder: str, stem: str, source: str) -> Path:
    """Path of the library below the cache: its digest holds all that decides what is in it."""
    machine = (_engine_version(), platform.machine(), platform.system(), *FLAGS)
    key = hashlib.sha256("\0".join((source, *machine)).encode()).hexdigest()[:16]
    return Path(folder) / f"{stem}_{key}.so"


def _built_below(root: Path, library: Path, source: str) -> Path:
    """The library at its path below a folder, which is made when it is not there."""
    if not root.is_absolute():
        # Without a home the cache's path begins with "~", which would be a folder in the working directory.
        raise FileNotFoundError(f"the user's cache '{root}' has no place")
    final = root / library
    if kept(final) is not None:
        return final
    final.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=final.parent) as scratch:
        text, built = Path(scratch) / f"{library.stem}.c", Path(scratch) / library.name
        text.write_text(source, encoding="utf-8")
        # Compilers leave what they need on the same disk, and zig keeps its own library there.
        compile_c([text], built, FLAGS, {"TMPDIR": scratch, "ZIG_GLOBAL_CACHE_DIR": str(root / "zig")})
        keep(final, built.read_bytes())
    return final


def _temporary_folders() -> list[Path]:
    """Folders for files that nobody keeps, the usual one first."""
    try:
        usual = [Path(tempfile.gettempdir())]
    except OSError:  # each of them is full or cannot be written
        usual = []
    return [*usual, Path("/dev/shm")]


@functools.cache
def _process_folder(parent: Path, process: int) -> Path:
    """The folder that a process has below another one until it ends."""
    folder = Path(tempfile.mkdtemp(prefix="skylimb_", dir=parent))

    def remove() -> None:
        # A forked process inherits what its parent has registered, but not the folder.
        if os.getpid() == process:
            shutil.rmtree(folder, ignore_errors=True)

    atexit.register(remove)
    return folder


_warned: set[Path] = set()


def _warn_once(cache: Path, problem: Exception) -> None:
    if cache in _warned:
        return
    _warned.add(cache)
    reason = "no compiler can write there" if isinstance(problem, CompileError) else problem
    warnings.warn(
        f"compiled code cannot be kept in '{cache}' ({reason}): every process makes its own",
        UserWarning,
        stacklevel=3,
    )


def load_library(path: Path) -> ctypes.CDLL:
    """A compiled library.

    Raises:
        CompileError: when the system refuses it.
    """
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        raise CompileError(f"the compiled library '{path}' cannot be loaded: {error}") from error


def compile_c(
    sources: Sequence[Path], output: Path, flags: Sequence[str], variables: Mapping[str, str] | None = None
) -> None:
    """Compile C files into one output with the first compiler that can.

    Args:
        sources: the files.
        output: a library, program or object file, as the flags say.
        flags: of the compiler.
        variables: of the compiler's environment, besides this process's.

    Raises:
        CompileError: with what each compiler said.
    """
    headers = [f"-I{folder / 'include'}" for folder in _engine_folders()]
    arguments = [*flags, *headers, *map(str, sources), "-o", str(output), "-lm"]
    problems = []
    for compiler in compilers():
        try:
            code, said = _ended([*compiler, *arguments], {**os.environ, **(variables or {})})
        except (OSError, subprocess.TimeoutExpired) as error:
            problems.append(f"{compiler[0]}: {error}")
            continue
        if code == 0:
            return
        first = (said.strip() or "no message").splitlines()[0]
        problems.append(f"{' '.join(compiler)}: {first}")
    raise CompileError(
        "; ".join(problems)
        or "no C compiler found (cc, gcc, clang); one can be installed: pip install 'skylimb[compiler]'"
    )


def _ended(command: list[str], variables: Mapping[str, str]) -> tuple[int, str]:
    """Exit code of a compiler and what it complained of. Given up, it ends with all that it began."""
    with subprocess.Popen(
        command,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        env=variables,
        start_new_session=True,
    ) as process:
        try:
            said = process.communicate(timeout=_PATIENCE)[1]
        except BaseException:
            if hasattr(os, "killpg"):
                os.killpg(process.pid, signal.SIGKILL)
            process.kill()
            raise
        return process.returncode, said


def compilers() -> list[list[str]]:
    """Commands of this machine's C compilers, first the one that the environment variable CC names."""
    wanted = os.environ.get("CC", "").split()
    found = [wanted] if wanted else []
    found += [[path] for name in ("cc", "gcc", "clang") if (path := shutil.which(name))]
    if find_spec("ziglang"):
        found.append([sys.executable, "-m", "ziglang", "cc"])
    return found


@functools.cache
def compiler_version() -> str:
    """The first compiler's own words on its version, and the flags it is given; "none" without a compiler."""
    for compiler in compilers():
        with contextlib.suppress(OSError, subprocess.TimeoutExpired):
            said = subprocess.run(
                [*compiler, "--version"], capture_output=True, text=True, timeout=20, check=False
            )
            if said.returncode == 0 and said.stdout.strip():
                return f"{said.stdout.strip().splitlines()[0]}, {' '.join(FLAGS)}"
    return "none"


def _engine_folders() -> list[Path]:
    """Where the engine's package is, found without importing it; none without an engine."""
    found = find_spec("mujoco")
    return [Path(folder) for folder in (found.submodule_search_locations or ())] if found else []


def has_engine() -> bool:
    """Whether the engine is installed, so that code may include its headers."""
    return bool(_engine_folders())


@functools.cache
def _engine_version() -> str:
    try:
        return version("mujoco")
    except PackageNotFoundError:
        return "none"


def engine_library() -> Path:
    """The engine's own shared library.

    Raises:
        CompileError: when it is not where the engine's package is.
    """
    folder = next(iter(_engine_folders()), Path("mujoco"))
    names = {"Darwin": "libmujoco*.dylib", "Windows": "mujoco.dll"}
    found = sorted(folder.glob(names.get(platform.system(), "libmujoco.so*")))
    if not found:
        raise CompileError(f"the engine's library is not in {folder}")
    return found[0]
