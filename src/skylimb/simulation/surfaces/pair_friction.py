"""Writes the friction of the place where the tip is into the model, once a control tick."""

from __future__ import annotations

import math
from typing import NamedTuple

import mujoco
import numpy as np

from skylimb.simulation.contact_keys import PAIR_NAME
from skylimb.simulation.surfaces.surface import Surface

_MOST_CELLS = 1000  # along one direction of the look-up table


class FrictionTable(NamedTuple):
    """Friction and adhesion of a surface sampled once, so that an update in flight is a look-up.

    Attributes:
        frictions: coefficients in cells over the surface's `size`, (along u, along v).
        adhesions: N, the same.
        origin: the surface's, W, m.
        motion_axis: unit vector along which it moves, W.
        R_WS: (3, 3) columns w, u, v.
        half: half of its extent along u and v, m.
        static_ratio: friction at rest over friction in motion.
        static_speed: slip speed over which it falls, m/s.
        stiffness: N/m.
    """

    frictions: np.ndarray
    adhesions: np.ndarray
    origin: np.ndarray
    motion_axis: np.ndarray
    R_WS: np.ndarray
    half: tuple[float, float]
    static_ratio: float
    static_speed: float
    stiffness: float


def friction_table(surface: Surface) -> FrictionTable:
    """Sample a surface at half its friction map's own blending width, or a thousandth of its size."""
    if surface.friction_map is None:
        frictions, adhesions = np.array([[surface.friction]]), np.array([[surface.adhesion]])
    else:
        pitch = 0.5 * surface.friction_map.blend
        nu, nv = (min(_MOST_CELLS, max(1, math.ceil(extent / pitch))) for extent in surface.size)
        mid_u = ((np.arange(nu) + 0.5) / nu - 0.5) * surface.size[0]
        mid_v = ((np.arange(nv) + 0.5) / nv - 0.5) * surface.size[1]
        over = surface.friction_map.over((surface.friction, surface.adhesion), surface.size)
        frictions, adhesions = over(*np.meshgrid(mid_u, mid_v, indexing="ij"))
    return FrictionTable(
        frictions=frictions,
        adhesions=adhesions,
        origin=np.asarray(surface.position, dtype=float),
        motion_axis=surface.motion_axis,
        R_WS=surface.R_WS,
        half=(0.5 * surface.size[0], 0.5 * surface.size[1]),
        static_ratio=surface.static_ratio,
        static_speed=surface.static_speed,
        stiffness=surface.stiffness,
    )


class PairFriction:
    """Friction and adhesion of one contact pair that follow the tip over a surface."""

    def __init__(self, model: mujoco.MjModel, surface: Surface, name: str = PAIR_NAME) -> None:
        pair, table = model.pair(name).id, friction_table(surface)
        self._friction, self._adhesion = model.pair_friction[pair], model.pair_adhesion[pair : pair + 1]
        self._gap, self._stiffness = model.pair_gap[pair : pair + 1], table.stiffness
        # Plain floats and lists: an update has a microsecond or two.
        self._origin, self._axis = table.origin.tolist(), table.motion_axis.tolist()
        self._w, self._u, self._v = table.R_WS.T.tolist()
        self._ratio, self._speed = table.static_ratio, table.static_speed
        self._half, self._cells = table.half, table.frictions.shape
        self._frictions, self._adhesions = table.frictions.tolist(), table.adhesions.tolist()

    def update(
        self,
        tip: tuple[float, ...] | np.ndarray,
        velocity: tuple[float, ...] | np.ndarray = (0.0, 0.0, 0.0),
        displacement: float = 0.0,
        wall_speed: float = 0.0,
    ) -> float:
        """Write friction and adhesion for a tip at `tip` (W, m) at `velocity` (W, m/s); returns the first.

        `displacement` (m) and `wall_speed` (m/s) are `Surface.motion` at this time.
        """
        o, a, u, v = self._origin, self._axis, self._u, self._v
        x = tip[0] - o[0] - displacement * a[0]
        y = tip[1] - o[1] - displacement * a[1]
        z = tip[2] - o[2] - displacement * a[2]
        i = int((0.5 + 0.5 * (x * u[0] + y * u[1] + z * u[2]) / self._half[0]) * self._cells[0])
        j = int((0.5 + 0.5 * (x * v[0] + y * v[1] + z * v[2]) / self._half[1]) * self._cells[1])
        i = min(max(i, 0), self._cells[0] - 1)
        j = min(max(j, 0), self._cells[1] - 1)
        friction = self._frictions[i][j]
        if self._ratio != 1.0:
            friction *= self._static(velocity, wall_speed)
        self._friction[0] = self._friction[1] = friction
        adhesion = self._adhesions[i][j]
        if adhesion != self._adhesion[0]:
            self._adhesion[0], self._gap[0] = adhesion, adhesion / self._stiffness
        return friction

    def _static(self, velocity: tuple[float, ...] | np.ndarray, wall_speed: float) -> float:
        """Stribeck's factor; slip is the tip's motion against the wall within the wall's flat plane."""
        a, w = self._axis, self._w
        x, y, z = (velocity[k] - wall_speed * a[k] for k in range(3))
        along = x * w[0] + y * w[1] + z * w[2]
        slip = x * x + y * y + z * z - along * along
        return 1.0 + (self._ratio - 1.0) * math.exp(-slip / self._speed**2)
