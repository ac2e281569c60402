"""The links and joints of a robot, as its URDF says.

Records with arrays compare by identity: whether two robots are the same is what their digests tell.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np


def zeros() -> np.ndarray:
    """A place of its own for each record, (3,)."""
    return np.zeros(3)


class Fixed:
    """Copies the arrays of a frozen dataclass and makes them read-only: nothing changes it by accident."""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if isinstance(value, np.ndarray):
                kept = np.array(value, dtype=float)
                kept.setflags(write=False)
                object.__setattr__(self, name, kept)


@dataclass(frozen=True, eq=False)
class Inertial(Fixed):
    """Mass properties of one link.

    Attributes:
        mass: kg.
        com: (3,) centre of mass in the link frame, m.
        inertia: (3, 3) about the centre of mass, in the link frame's axes, kg m^2.
    """

    mass: float = 0.0
    com: np.ndarray = field(default_factory=zeros)
    inertia: np.ndarray = field(default_factory=lambda: np.zeros((3, 3)))


@dataclass(frozen=True, eq=False)
class Visual(Fixed):
    """One primitive (or mesh) that draws a link.

    Attributes:
        shape: kind of geometry.
        size: full edge lengths of a box; (radius, length) of a cylinder along z; (radius,) of a sphere; scale
            of a mesh. m.
        xyz: (3,) centre in the link frame, m.
        R: (3, 3) orientation in the link frame.
        rgba: colour, 0 .. 1.
        mesh: file of a mesh, else None.
    """

    shape: Literal["box", "cylinder", "sphere", "mesh"]
    size: tuple[float, ...]
    xyz: np.ndarray
    R: np.ndarray
    rgba: tuple[float, float, float, float]
    mesh: Path | None = None


@dataclass(frozen=True)
class Link:
    """A rigid link of the URDF: what it weighs, how it looks, and what it may collide with itself by."""

    name: str
    inertial: Inertial = field(default_factory=Inertial)
    visuals: tuple[Visual, ...] = ()
    collisions: tuple[Visual, ...] = ()


@dataclass(frozen=True, eq=False)
class Joint(Fixed):
    """A joint of the URDF: the child link's frame seen from the parent link's.

    Attributes:
        xyz: (3,) origin of the child frame in the parent frame, m.
        R: (3, 3) orientation of the child frame in the parent frame at joint angle zero.
        axis: (3,) unit axis in the child frame.
        lower: lower angle limit, rad (-inf when continuous).
        upper: upper angle limit, rad (inf when continuous).
        effort: torque limit, N m.
        speed: speed limit, rad/s.
        damping: viscous friction, N m s/rad.
        friction: dry friction, N m.
    """

    name: str
    kind: Literal["revolute", "continuous", "fixed"]
    parent: str
    child: str
    xyz: np.ndarray
    R: np.ndarray
    axis: np.ndarray
    lower: float
    upper: float
    effort: float
    speed: float
    damping: float
    friction: float
