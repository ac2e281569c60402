"""What a surface is in the engine's model, as plain data: `simulation.surface_bodies` writes it there."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

BODY = "surface"
GEOM = "surface"
JOINT = "surface_slide"
Numbers = Sequence[float] | np.ndarray

COLOR = (0.78, 0.72, 0.60, 1.0)


class Sheet(NamedTuple):
    """A mesh that is only looked at: vertices (n, 3), m, and triangles (k, 3)."""

    vertices: np.ndarray
    faces: np.ndarray


class Shaped(NamedTuple):
    """A shape whose contact is code of our own.

    Attributes:
        mark: by which the engine's collision knows the kind of shape.
        numbers: of the shape.
        library: the kind's code, which `skylimb_install` enters into a slot of the engine's table.
    """

    mark: float
    numbers: np.ndarray
    library: ctypes.CDLL


class Geom(NamedTuple):
    """A part of a surface, in the surface's own axes (w into it, u and v along it).

    Attributes:
        kind: of the engine's geoms.
        size: as the engine takes it for that kind, m.
        position: of its middle, m.
        quaternion: of its axes, or None.
        name: of what is touched; empty for what is only looked at.
        color: with which it is looked at; None for what is only touched.
        turns: whether it is on the part that turns on a hinge.
        sheet: of a mesh.
        shaped: of an ellipsoid that stands for a shape with contact code of its own.
    """

    kind: Literal["plane", "box", "sphere", "cylinder", "ellipsoid", "mesh"]
    size: Numbers = (0.0, 0.0, 0.0)
    position: Numbers = (0.0, 0.0, 0.0)
    quaternion: Numbers | None = None
    name: str = ""
    color: tuple[float, float, float, float] | None = COLOR
    turns: bool = False
    sheet: Sheet | None = None
    shaped: Shaped | None = None


class Hinge(NamedTuple):
    """A part that the engine turns about w, balanced.

    Attributes:
        quaternion: of the part's axes at the first stop.
        travel: from the first stop to the second, rad.
        damping: N m s/rad.
        friction: dry, N m.
        mass: kg.
        inertia: about every axis, kg m^2.
    """

    quaternion: Numbers
    travel: float
    damping: float
    friction: float
    mass: float
    inertia: float


def name_of(index: int) -> str:
    """Of one of several geoms that are touched."""
    return GEOM if index == 0 else f"{GEOM}_{index}"
