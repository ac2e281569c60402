"""The inclined board: the paper's surface."""

from __future__ import annotations

from typing import Literal

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from skylimb.keys import configuration
from skylimb.simulation.surfaces.surface import COLOR, GEOM, Surface

_THICKNESS = 0.02  # m, of the board that is looked at
_HALF_WALL = 25.0  # m, of the box that stands for a plane when the board moves


@configuration
class Board(Surface):
    """A flat board, without end for the contact; `size` is what is drawn of it."""

    kind: Literal["board"] = "board"

    def height(self, u: ArrayLike, v: ArrayLike) -> np.ndarray:
        """The height above the flat plane: zero everywhere."""
        return np.zeros(np.broadcast(u, v).shape)

    def local_closest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The projection onto the plane w = 0, and the normal -w."""
        foot = np.array(points, dtype=float)
        foot[..., 0] = 0.0
        normal = np.zeros_like(foot)
        normal[..., 0] = -1.0
        return foot, normal

    def add_geometry(self, spec: mujoco.MjSpec, body: mujoco.MjsBody) -> None:
        """An infinite plane; a moving board collides as a wide box, since the engine's planes cannot move."""
        if self.moves:
            body.add_geom(
                name=GEOM,
                type=mujoco.mjtGeom.mjGEOM_BOX,
                size=[_HALF_WALL] * 3,
                pos=[_HALF_WALL, 0.0, 0.0],
                group=4,
                contype=0,
                conaffinity=0,
            )
        else:
            body.add_geom(
                name=GEOM,
                type=mujoco.mjtGeom.mjGEOM_PLANE,
                size=[0.0, 0.0, 1.0],
                # A plane's outside is its +z; the surface's is -w.
                quat=[np.sqrt(0.5), 0.0, -np.sqrt(0.5), 0.0],
                group=4,
                contype=0,
                conaffinity=0,
            )
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[0.5 * _THICKNESS, 0.5 * self.size[0], 0.5 * self.size[1]],
            pos=[0.5 * _THICKNESS, 0.0, 0.0],
            rgba=COLOR,
            group=1,
            contype=0,
            conaffinity=0,
            mass=0.0,
        )
