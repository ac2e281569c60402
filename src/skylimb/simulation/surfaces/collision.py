"""Curved shapes as machine code, which the engine's collision and the analysis both call.

The engine looks its collision functions up in a table that programs may change. The C of a kind of shape is
compiled once, with the machine's C compiler, into the user's cache; `surface_bodies` puts it into the table
in the place of the sphere-ellipsoid function. What is not of that kind goes on to the function that was there
before, so that several kinds fly in one process and other ellipsoids are left to the engine.
"""

from __future__ import annotations

import ctypes
import functools
import hashlib
import threading
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from skylimb.base.errors import CompileError
from skylimb.simulation.compiling import built_library, has_engine, load_library

_HEAD = """@ENGINE@
#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT
#endif
#include <math.h>
#ifdef ENGINE
#include <mujoco/mujoco.h>
#else
typedef double mjtNum;
#endif
"""
_lock = threading.Lock()


class Kind(NamedTuple):
    """A kind of shape as machine code.

    Attributes:
        mark: first number of every such surface's data in a model, and user value of the geom that stands
            for it.
        library: its functions.
    """

    mark: float
    library: ctypes.CDLL

    def closest(self, numbers: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Nearest points of the shape with these numbers to points (..., 3), and outward unit normals."""
        points = np.ascontiguousarray(points, dtype=float)
        feet, normals = np.empty_like(points), np.empty_like(points)
        self._call("skylimb_closest", numbers, points.size // 3, points, feet, normals)
        return feet, normals

    def heights(self, numbers: np.ndarray, u: ArrayLike, v: ArrayLike) -> np.ndarray:
        """h, h_u, h_v, h_uu, h_uv, h_vv (..., 6) of a graph with these numbers at (u, v), each (...)."""
        u, v = (np.array(x, dtype=float, order="C") for x in np.broadcast_arrays(u, v))
        found = np.empty((*u.shape, 6))
        self._call("skylimb_heights", numbers, u.size, u, v, found)
        return found

    def _call(self, name: str, numbers: np.ndarray, count: int, *arrays: np.ndarray) -> None:
        pointers = (ctypes.c_void_p(array.ctypes.data) for array in (numbers, *arrays))
        first, *others = pointers
        self.library[name](first, count, *others)


def native_text(name: str) -> str:
    """The text of one of the C files in this folder."""
    return Path(__file__).with_name(name).read_text("utf-8")


def whole_source(shape: str) -> tuple[float, str]:
    """The mark of a kind of shape, and all of its C: the shape's own, and what every shape needs."""
    mark = float(int(hashlib.sha256(shape.encode()).hexdigest()[:12], 16))
    head = _HEAD.replace("@ENGINE@", "#define ENGINE" if has_engine() else "")
    return mark, f"{head}#define MARK {mark!r}\n{shape}\n{native_text('collision.c')}"


@functools.cache
def _built(shape: str) -> Kind:
    mark, source = whole_source(shape)
    try:
        return Kind(mark, load_library(built_library("collision", "collision", source)))
    except CompileError as error:
        raise CompileError(f"surfaces with a shape of their own need a C compiler: {error}") from error


def kind_of(shape: str) -> Kind:
    """A kind of shape, from its C, as `collision.c` asks for it.

    Raises:
        CompileError: when there is no compiler that builds it.
    """
    with _lock:
        return _built(shape)
