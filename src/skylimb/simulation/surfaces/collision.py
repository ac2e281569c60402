"""Puts the contact of a sphere with a curved surface in the place of the engine's sphere-ellipsoid function.

The engine looks its collision functions up in a table that programs may change. `collision.c` is compiled
once, with the machine's C compiler, into the user's cache. Every ellipsoid that is not one of our surfaces is
left to the engine's own function.
"""

from __future__ import annotations

import ctypes
import functools
from pathlib import Path

import mujoco

from skylimb.errors import CompileError
from skylimb.simulation.compiling import built_library, engine_library, load_library
from skylimb.simulation.surfaces.shape import MARK

_SOURCE = Path(__file__).with_name("collision.c")
_KINDS = int(mujoco.mjtGeom.mjNGEOMTYPES)
_SPHERE, _ELLIPSOID = int(mujoco.mjtGeom.mjGEOM_SPHERE), int(mujoco.mjtGeom.mjGEOM_ELLIPSOID)


@functools.cache
def install_collision() -> None:
    """Install the collision function for this process.

    Raises:
        CompileError: when there is no compiler that builds it.
    """
    source = f"#define MARK {MARK!r}\n{_SOURCE.read_text('utf-8')}"
    try:
        library = load_library(built_library("collision", "collision", source))
    except CompileError as error:
        raise CompileError(f"surfaces with a shape of their own need a C compiler: {error}") from error
    table = _collision_table()
    slot = _SPHERE * _KINDS + _ELLIPSOID
    library.skylimb_set_engines_own.argtypes = [ctypes.c_void_p]
    library.skylimb_set_engines_own(table[slot])
    table[slot] = ctypes.cast(library.skylimb_collide, ctypes.c_void_p).value


def _collision_table() -> ctypes.Array[ctypes.c_void_p]:
    return (ctypes.c_void_p * (_KINDS * _KINDS)).in_dll(ctypes.CDLL(str(engine_library())), "mjCOLLISIONFUNC")
