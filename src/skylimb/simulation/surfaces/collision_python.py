"""The collision function in Python, for machines without a C compiler.

The engine hands over bare pointers. Where the few fields that are needed lie in its structures is found
once, by looking for known values in the memory of a small model.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from skylimb.simulation.surfaces.collision_scalar import touch
from skylimb.simulation.surfaces.shape import MARK

_SIGNATURE = ctypes.CFUNCTYPE(
    ctypes.c_int,
    ctypes.c_void_p,
    ctypes.c_void_p,
    ctypes.POINTER(ctypes.c_double),
    ctypes.c_int,
    ctypes.c_int,
    ctypes.c_double,
)
_WORDS = 1 << 17  # how far to look into a structure; the engine's data is some 160 kB
_MAX_DEPTH = 0.05  # m, as in collision.c

_surfaces: dict[float, list[float]] = {}
_callbacks: list[Any] = []


def register_numbers(identity: float, numbers: Sequence[float] | np.ndarray) -> None:
    """Let the Python collision function find the surface that a model's data calls `identity`."""
    _surfaces[identity] = [float(number) for number in numbers]


def collision_callback(engines_own: int | None) -> Any:
    """The function for the engine's table; it is kept for as long as the process lives."""
    own = _SIGNATURE(engines_own) if engines_own else None
    fields = _Fields()

    def collide(model: int, data: int, contact: Any, sphere: int, surface: int, margin: float) -> int:
        identity = fields.identity(model, surface)
        if identity is None:
            return own(model, data, contact, sphere, surface, margin) if own else 0
        places, turns = fields.array(data, fields.xpos), fields.array(data, fields.xmat)
        radius = fields.array(model, fields.size)[3 * sphere]
        x, y, z = places[3 * sphere : 3 * sphere + 3]
        ox, oy, oz = places[3 * surface : 3 * surface + 3]
        R = turns[9 * surface : 9 * surface + 9]
        dx, dy, dz = x - ox, y - oy, z - oz
        w, u, v = (R[i] * dx + R[3 + i] * dy + R[6 + i] * dz for i in range(3))
        reach = radius + margin
        distance, nw, nu, nv = touch(_surfaces[identity], w, u, v, reach)
        if distance > reach or distance < -_MAX_DEPTH:
            return 0
        gap = distance - radius
        contact[0] = gap
        back = distance - 0.5 * gap
        for i, place in enumerate((x, y, z)):
            outward = R[3 * i] * nw + R[3 * i + 1] * nu + R[3 * i + 2] * nv
            contact[1 + i] = place - outward * back
            contact[4 + i] = -outward
            contact[7 + i] = 0.0
        return 1

    callback = _SIGNATURE(collide)
    _callbacks.append(callback)
    return callback


class _Fields:
    """Offsets of the engine's fields in its structures, in words of 8 bytes."""

    def __init__(self) -> None:
        models = [_probe(users) for users in (13, 17)]
        model, data = models[0]
        self.size = _offset(model._address, model.geom_size.ctypes.data)
        self.user = _offset(model._address, model.geom_user.ctypes.data)
        self.xpos = _offset(data._address, data.geom_xpos.ctypes.data)
        self.xmat = _offset(data._address, data.geom_xmat.ctypes.data)
        words = [ctypes.cast(m._address, ctypes.POINTER(ctypes.c_int64)) for m, _ in models]
        # The number of user values a geom has is the one word that is 13 in the first model and 17 in the
        # second.
        self.users = next(i for i in range(_WORDS) if words[0][i] == 13 and words[1][i] == 17)

    def array(self, structure: int, offset: int) -> Any:
        """The array of numbers that a structure points to, to be indexed at one's own risk."""
        return ctypes.cast(structure, _POINTERS)[offset]

    def identity(self, model: int, geom: int) -> float | None:
        """The identity of the surface that a geom stands for, or None for a geom that is none of ours."""
        users = ctypes.cast(model, _INTEGERS)[self.users]
        if users < 2:
            return None
        mark, identity = self.array(model, self.user)[users * geom : users * geom + 2]
        return identity if mark == MARK else None


_POINTERS = ctypes.POINTER(ctypes.POINTER(ctypes.c_double))
_INTEGERS = ctypes.POINTER(ctypes.c_int64)


def _probe(users: int) -> tuple[mujoco.MjModel, mujoco.MjData]:
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[1.0, 0.0, 0.0], userdata=np.arange(1.0, users + 1.0)
    )
    model = spec.compile()
    return model, mujoco.MjData(model)


def _offset(structure: int, pointer: int) -> int:
    words = ctypes.cast(structure, ctypes.POINTER(ctypes.c_uint64))
    found = next(i for i in range(_WORDS) if words[i] == pointer)
    # Empty arrays before it have the same address: the last of them is the one that holds something.
    while words[found + 1] == pointer:
        found += 1
    return found
