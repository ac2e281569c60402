"""Puts the contact of a sphere with a curved surface in the place of the engine's sphere-ellipsoid function.

The engine looks its collision functions up in a table that programs may change. `collision.c` is compiled
once, with the machine's C compiler, into the user's cache. Without a compiler the same work is done in
Python, several times slower. Either leaves every ellipsoid that is not one of our surfaces to the engine's
own function.
"""

from __future__ import annotations

import ctypes
import functools
import hashlib
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Sequence
from pathlib import Path

import mujoco
import platformdirs

_SOURCE = Path(__file__).with_name("collision.c")
_KINDS = int(mujoco.mjtGeom.mjNGEOMTYPES)
_SPHERE, _ELLIPSOID = int(mujoco.mjtGeom.mjGEOM_SPHERE), int(mujoco.mjtGeom.mjGEOM_ELLIPSOID)


@functools.cache
def install_collision() -> str:
    """Install the collision function for this process; returns "compiled" or "python".

    The environment variable SKYLIMB_COLLISION=python asks for the Python form.
    """
    table = _collision_table()
    slot = _SPHERE * _KINDS + _ELLIPSOID
    engines_own = table[slot]
    if os.environ.get("SKYLIMB_COLLISION", "compiled") != "python":
        try:
            library = ctypes.CDLL(str(_compiled()))
        except (OSError, RuntimeError) as error:
            warnings.warn(
                f"no compiled collision function for curved surfaces, using a slower one: {error}",
                UserWarning,
                stacklevel=2,
            )
        else:
            library.skylimb_set_engines_own.argtypes = [ctypes.c_void_p]
            library.skylimb_set_engines_own(engines_own)
            table[slot] = ctypes.cast(library.skylimb_collide, ctypes.c_void_p).value
            return "compiled"
    from skylimb.simulation.surfaces.collision_python import collision_callback

    table[slot] = ctypes.cast(collision_callback(engines_own), ctypes.c_void_p).value
    return "python"


def _collision_table() -> ctypes.Array[ctypes.c_void_p]:
    folder = Path(mujoco.__file__).parent
    names = {"Darwin": "libmujoco*.dylib", "Windows": "mujoco.dll"}
    found = sorted(folder.glob(names.get(platform.system(), "libmujoco.so*")))
    if not found:
        raise RuntimeError(f"the engine's library is not in {folder}")
    return (ctypes.c_void_p * (_KINDS * _KINDS)).in_dll(ctypes.CDLL(str(found[0])), "mjCOLLISIONFUNC")


def _compiled() -> Path:
    """Path of the compiled library; builds it when the cache has none for this source, engine and machine."""
    source = _SOURCE.read_bytes()
    parts = (source, mujoco.__version__.encode(), platform.machine().encode(), platform.system().encode())
    key = hashlib.sha256(b"\0".join(parts)).hexdigest()[:16]
    folder = Path(platformdirs.user_cache_dir("skylimb")) / "collision"
    library = folder / f"collision_{key}.so"
    if not library.is_file():
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder) as scratch:
            built = Path(scratch) / library.name
            _compile(_SOURCE, built)
            # Renaming is atomic, so that two processes that build at once do not see half a file.
            os.replace(built, library)
    return library


def _compile(source: Path, library: Path) -> None:
    include = Path(mujoco.__file__).parent / "include"
    flags = ["-O2", "-shared", "-fPIC", f"-I{include}", str(source), "-o", str(library), "-lm"]
    problems = []
    for compiler in _compilers():
        try:
            result = subprocess.run(
                [*compiler, *flags], capture_output=True, text=True, timeout=120, check=False
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            problems.append(f"{compiler[0]}: {error}")
            continue
        if result.returncode == 0:
            return
        first = (result.stderr.strip() or "no message").splitlines()[0]
        problems.append(f"{' '.join(compiler)}: {first}")
    raise RuntimeError("; ".join(problems) or "no C compiler found (cc, gcc, clang, or the ziglang package)")


def _compilers() -> list[Sequence[str]]:
    wanted = os.environ.get("CC", "").split()
    found: list[Sequence[str]] = [wanted] if wanted else []
    found += [[path] for name in ("cc", "gcc", "clang") if (path := shutil.which(name))]
    from importlib.util import find_spec

    if find_spec("ziglang"):
        found.append([sys.executable, "-m", "ziglang", "cc"])
    return found
