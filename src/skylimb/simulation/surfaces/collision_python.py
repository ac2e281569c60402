"""The collision function in Python, for machines without a C compiler.

The engine hands over bare pointers. Where the few fields that are needed lie in its structures is found
once, by looking for known values in the memory of a small model.
"""

from __future__ import annotations

import ctypes
from typing import Any

import mujoco
import numpy as np

from skylimb.simulation.surfaces.shape import MARK, Shape

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
_NUMBERS_PER_CONTACT = 10  # distance, position, normal, tangent
_MAX_DEPTH = 0.05  # m, as in collision.c

_shapes: dict[float, Shape] = {}


def register_shape(identity: float, shape: Shape) -> None:
    """Let the Python collision function find the shape that a model's data calls `identity`."""
    _shapes[identity] = shape


def collision_callback(engines_own: int | None) -> Any:
    """The function for the engine's table; keep a reference to it as long as the engine may call it."""
    own = _SIGNATURE(engines_own) if engines_own else None
    fields = _Fields()

    def collide(model: int, data: int, contacts: Any, sphere: int, surface: int, margin: float) -> int:
        identity = fields.identity(model, surface)
        if identity is None:
            return own(model, data, contacts, sphere, surface, margin) if own else 0
        shape = _shapes[identity]
        x = fields.vector(data, fields.xpos, 3 * sphere, 3)
        origin = fields.vector(data, fields.xpos, 3 * surface, 3)
        R = fields.vector(data, fields.xmat, 9 * surface, 9).reshape(3, 3)
        radius = fields.vector(model, fields.size, 3 * sphere, 1)[0]
        local = R.T @ (x - origin)
        if not np.isfinite(shape.height(local[1], local[2])):
            return 0
        foot, normal = shape.closest(local)
        distance = float((local - foot) @ normal)
        if distance > radius + margin or distance < -_MAX_DEPTH:
            return 0
        outward = R @ normal
        gap = distance - radius
        contacts[0] = gap
        for i in range(3):
            contacts[1 + i] = x[i] - outward[i] * (distance - 0.5 * gap)
            contacts[4 + i] = -outward[i]
            contacts[7 + i] = 0.0
        return 1

    callback = _SIGNATURE(collide)
    _keep.append(callback)
    return callback


_keep: list[Any] = []


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

    def vector(self, structure: int, offset: int, first: int, count: int) -> np.ndarray:
        """`count` numbers from `first` on, of the array that a structure points to."""
        array = ctypes.cast(structure, ctypes.POINTER(ctypes.POINTER(ctypes.c_double)))[offset]
        return np.array(array[first : first + count])

    def identity(self, model: int, geom: int) -> float | None:
        """The identity of the surface that a geom stands for, or None for a geom that is none of ours."""
        users = ctypes.cast(model, ctypes.POINTER(ctypes.c_int64))[self.users]
        if users < 2:
            return None
        mark, identity = self.vector(model, self.user, users * geom, 2)
        return float(identity) if mark == MARK else None


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
