"""Puts the contact of a sphere with a curved surface in the place of the engine's sphere-ellipsoid function.

The engine looks its collision functions up in a table that programs may change. `collision.c` is compiled
once, with the machine's C compiler, into the user's cache. Without a compiler the same work is done in
Python, several times slower. Either leaves every ellipsoid that is not one of our surfaces to the engine's
own function.
"""

from __future__ import annotations

import ctypes
import functools
import os
import warnings
from pathlib import Path

import mujoco

from skylimb.errors import CompileError
from skylimb.simulation.compiling import built_library, engine_library

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
            library = ctypes.CDLL(str(built_library("collision", "collision", _SOURCE.read_text("utf-8"))))
        except (OSError, CompileError) as error:
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
    return (ctypes.c_void_p * (_KINDS * _KINDS)).in_dll(ctypes.CDLL(str(engine_library())), "mjCOLLISIONFUNC")
