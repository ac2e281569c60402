"""A surface that was somewhere else at every tick, as the analysis asks for it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from skylimb.base.rotations import quaternion_from_rotation
from skylimb.simulation.surface_state import state_of
from skylimb.simulation.surfaces import Surface, Valve
from skylimb.simulation.surfaces.placement import surface_rotation
from skylimb.simulation.surfaces.touched import Touched


class SurfaceAt(Touched):
    """A surface with a pose at every tick, asked for at the ticks' times.

    Args:
        surface: as it was before take-off.
        period: of a tick, s.
        origins: of its axes at every tick, W, m, (ticks, 3).
        axes: its axes (w, u, v) as columns, W, in each of the attitudes that it had, (attitudes, 3, 3).
        which: of them it had at every tick, (ticks,).
        velocity: with which it moves, W, m/s, (ticks, 3).
        there: whether it is there, (ticks,).
        turned: of a surface of which a part turns, that part's axes in the surface's, (ticks, 3, 3).
    """

    def __init__(
        self,
        surface: Surface,
        period: float,
        origins: np.ndarray,
        axes: np.ndarray,
        which: np.ndarray,
        velocity: np.ndarray,
        there: np.ndarray,
        turned: np.ndarray | None = None,
    ) -> None:
        self._surface, self._period = surface, period
        self.position, self._axes, self._which = origins, axes, which
        self._velocity, self._there, self._turned = velocity, there, turned

    @property
    def quaternion(self) -> np.ndarray:
        """The attitude of the axes at every tick, (ticks, 4)."""
        return np.array([quaternion_from_rotation(R) for R in self._axes])[self._which]

    def velocity(self, time: np.ndarray) -> np.ndarray:
        """As of any surface; of a part that turns, where the tip is."""
        return self._velocity[self._ticks(time)]

    def signed_distance(self, points: np.ndarray, time: Any = None) -> np.ndarray:
        """As of any surface; NaN while it is taken away."""
        return np.where(self._there[self._ticks(time)], super().signed_distance(points, time), np.nan)

    def unroll(self, u: ArrayLike, v: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """As before take-off."""
        return self._surface.unroll(u, v)

    def in_world(self, vectors: np.ndarray, time: np.ndarray) -> np.ndarray:
        """Vectors of the surface's axes at these times in those of W."""
        return _turn(self._axes[self._which[self._ticks(time)]], vectors)

    def _ticks(self, time: np.ndarray) -> np.ndarray:
        return np.round(time / self._period).astype(int)

    def nearest(self, points: np.ndarray, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Points, closest points and normals in the surface's axes, (n, 3) each."""
        ticks = self._ticks(time)
        slid = self._surface.motion(time)[0][:, None] * self._surface.motion_axis
        local = _turn_back(self._axes[self._which[ticks]], points - self.position[ticks] - slid)
        if self._turned is None:
            return local, *self._surface.local_closest(local)
        part = self._turned[ticks]
        foot, normal = self._surface.local_closest(_turn_back(part, local))
        return local, _turn(part, foot), _turn(part, normal)


def changed_surface(surface: Surface, table: np.ndarray, period: float) -> SurfaceAt:
    """A surface that was changed in flight.

    Args:
        surface: as it was before take-off.
        table: what it was at every tick (`surface_table`).
        period: of a tick, s.
    """
    new = np.concatenate([[True], np.any(table[1:, :6] != table[:-1, :6], axis=1)])
    poses = [state_of(row) for row in table[new]]
    axes = [surface_rotation(surface.contact_axis, pose.slope, pose.pitch, pose.roll) for pose in poses]
    velocity = surface.velocity(period * np.arange(len(table)))
    which, there = np.cumsum(new) - 1, table[:, 8] > 0.0
    return SurfaceAt(surface, period, table[:, :3], np.array(axes), which, velocity, there)


def turned_valve(
    valve: Valve, angle: np.ndarray, rate: np.ndarray, tip: np.ndarray, period: float
) -> SurfaceAt:
    """A valve whose lever turned in flight; its trace is in the plane in which it turns.

    Args:
        valve: what turned.
        angle: of its hinge at every tick, rad, (ticks,).
        rate: of the angle, rad/s, (ticks,).
        tip: where the tip was, W, m, (ticks, 3).
        period: of a tick, s.
    """
    ticks, origin = len(angle), np.asarray(valve.position, dtype=float)
    velocity = rate[:, None] * np.cross(valve.R_WS[:, 0], tip - origin)
    turned = np.tile(np.eye(3), (ticks, 1, 1))
    turned[:, 1, 1] = turned[:, 2, 2] = np.cos(angle)
    turned[:, 2, 1], turned[:, 1, 2] = np.sin(angle), -np.sin(angle)
    origins, which, there = (
        np.tile(origin, (ticks, 1)),
        np.zeros(ticks, dtype=int),
        np.ones(ticks, dtype=bool),
    )
    return SurfaceAt(valve, period, origins, valve.R_WS[None], which, velocity, there, turned)


def _turn(axes: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    return np.einsum("nij,nj->ni", axes, vectors)


def _turn_back(axes: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    return np.einsum("nji,nj->ni", axes, vectors)
