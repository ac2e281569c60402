"""The inclined board: the paper's surface."""

from __future__ import annotations

from typing import Literal

import numpy as np

from skylimb.base.keys import configuration
from skylimb.simulation.surfaces.geom import GEOM, Geom
from skylimb.simulation.surfaces.surface import Surface

_THICKNESS = 0.02  # m, of the board that is looked at
_HALF_WALL = 25.0  # m, of the box that stands for a plane when the board moves


@configuration
class Board(Surface):
    """A flat board, without end for the contact; `size` is what is drawn of it."""

    kind: Literal["board"] = "board"

    def local_closest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The projection onto the plane w = 0, and the normal -w."""
        foot = np.array(points, dtype=float)
        foot[..., 0] = 0.0
        normal = np.zeros_like(foot)
        normal[..., 0] = -1.0
        return foot, normal

    @property
    def geoms(self) -> tuple[Geom, ...]:
        """An infinite plane; a moving board collides as a wide box, since the engine's planes cannot move."""
        # A plane's outside is its +z; the surface's is -w.
        upright = [np.sqrt(0.5), 0.0, -np.sqrt(0.5), 0.0]
        touched = (
            Geom("box", [_HALF_WALL] * 3, [_HALF_WALL, 0.0, 0.0], name=GEOM, color=None)
            if self.moves
            else Geom("plane", [0.0, 0.0, 1.0], quaternion=upright, name=GEOM, color=None)
        )
        half = 0.5 * np.array([_THICKNESS, *self.size])
        return touched, Geom("box", half, [0.5 * _THICKNESS, 0.0, 0.0])
