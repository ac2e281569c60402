"""C code compiled once, with the machine's compiler, into the user's cache under its digest."""

from __future__ import annotations

import hashlib
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import mujoco
import platformdirs

from skylimb.errors import CompileError

# The engine's own binaries ask for AVX on these machines; with it, code is a seventh shorter.
_WIDE = ("-mavx",) if platform.machine().lower() in ("x86_64", "amd64") else ()

FLAGS = ("-O2", "-ffp-contract=off", "-fno-math-errno", *_WIDE, "-shared", "-fPIC")
"""No fused multiply-add and no reordering, so that every machine computes the same numbers."""


def built_library(folder: str, stem: str, source: str) -> Path:
    """Path of the shared library made of a C source; built where the cache has none for this machine.

    Args:
        folder: below the user's cache.
        stem: how the library's name begins.
        source: the C code; it may include the engine's headers, and links to libm alone.

    Raises:
        CompileError: when no compiler is found, none accepts the source, or the cache cannot be written.
    """
    machine = (mujoco.__version__, platform.machine(), platform.system(), *FLAGS)
    key = hashlib.sha256("\0".join((source, *machine)).encode()).hexdigest()[:16]
    cache = Path(platformdirs.user_cache_dir("skylimb")) / folder
    library = cache / f"{stem}_{key}.so"
    if library.is_file():
        return library
    try:
        cache.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=cache) as scratch:
            text, built = Path(scratch) / f"{stem}.c", Path(scratch) / library.name
            text.write_text(source, encoding="utf-8")
            compile_c([text], built, FLAGS)
            # Renaming is atomic, so that two processes that build at once do not see half a file.
            os.replace(built, library)
    except OSError as error:
        raise CompileError(f"compiled code cannot be kept in '{cache}': {error}") from error
    return library


def compile_c(sources: Sequence[Path], output: Path, flags: Sequence[str]) -> None:
    """Compile C files into one output with the first compiler that can.

    Raises:
        CompileError: with what each compiler said.
    """
    include = Path(mujoco.__file__).parent / "include"
    arguments = [*flags, f"-I{include}", *map(str, sources), "-o", str(output), "-lm"]
    problems = []
    for compiler in compilers():
        try:
            result = subprocess.run(
                [*compiler, *arguments], capture_output=True, text=True, timeout=120, check=False
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            problems.append(f"{compiler[0]}: {error}")
            continue
        if result.returncode == 0:
            return
        first = (result.stderr.strip() or "no message").splitlines()[0]
        problems.append(f"{' '.join(compiler)}: {first}")
    raise CompileError(
        "; ".join(problems) or "no C compiler found (looked for cc, gcc, clang and the ziglang package)"
    )


def compilers() -> list[list[str]]:
    """Commands of this machine's C compilers, first the one that the environment variable CC names."""
    wanted = os.environ.get("CC", "").split()
    found = [wanted] if wanted else []
    found += [[path] for name in ("cc", "gcc", "clang") if (path := shutil.which(name))]
    if find_spec("ziglang"):
        found.append([sys.executable, "-m", "ziglang", "cc"])
    return found


def engine_library() -> Path:
    """The engine's own shared library.

    Raises:
        CompileError: when it is not where the engine's package is.
    """
    folder = Path(mujoco.__file__).parent
    names = {"Darwin": "libmujoco*.dylib", "Windows": "mujoco.dll"}
    found = sorted(folder.glob(names.get(platform.system(), "libmujoco.so*")))
    if not found:
        raise CompileError(f"the engine's library is not in {folder}")
    return found[0]
