"""What can change of a surface in flight, as a row of numbers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from skylimb.simulation.surfaces import Surface


class SurfaceState(NamedTuple):
    """What a surface is at a tick.

    Attributes:
        position: its origin, W, m, (3,).
        slope: rad.
        pitch: rad.
        roll: rad.
        friction: Coulomb coefficient.
        stiffness: N/m.
        present: 1, or 0 where it is taken away.
    """

    position: np.ndarray
    slope: float
    pitch: float
    roll: float
    friction: float
    stiffness: float
    present: float


POSE = slice(0, 6)
"""Place and attitude in a row."""

COLUMNS = {
    "position": slice(0, 3),
    "slope": slice(3, 4),
    "pitch": slice(4, 5),
    "roll": slice(5, 6),
    "friction": slice(6, 7),
    "stiffness": slice(7, 8),
    "present": slice(8, 9),
}
"""Where each number stands in a row."""


def first_row(surface: Surface) -> np.ndarray:
    """The row of a surface before take-off, (9,)."""
    names = ("slope", "pitch", "roll", "friction", "stiffness")
    return np.array([*surface.position, *(getattr(surface, name) for name in names), 1.0])


def state_of(row: np.ndarray) -> SurfaceState:
    """A row by name."""
    return SurfaceState(row[0:3], *map(float, row[3:9]))
