"""A surface whose pose changed in flight, as the analysis asks for it."""

from __future__ import annotations

import numpy as np

from skylimb.simulation.surface_state import state_of
from skylimb.simulation.surfaces import Surface
from skylimb.simulation.surfaces.placement import surface_rotation
from skylimb.spatial import quaternion_from_rotation


class MovedSurface:
    """A surface with a pose at every tick; its methods are those of `Surface`, at the ticks' times.

    Args:
        surface: as it was before take-off.
        table: what it was at every tick (`surface_table`).
        period: of a tick, s.
    """

    def __init__(self, surface: Surface, table: np.ndarray, period: float) -> None:
        self._surface, self._period = surface, period
        new = np.concatenate([[True], np.any(table[1:, :6] != table[:-1, :6], axis=1)])
        poses = [state_of(row) for row in table[new]]
        # Which of the few poses a tick has.
        self._which = np.cumsum(new) - 1
        self._origins = np.array([pose.position for pose in poses])
        self._axes = np.array(
            [surface_rotation(surface.contact_axis, pose.slope, pose.pitch, pose.roll) for pose in poses]
        )
        self._there = table[:, 8] > 0.0
        self.velocity = surface.velocity

    @property
    def position(self) -> np.ndarray:
        """The origin at every tick, W, m, (ticks, 3)."""
        return self._origins[self._which]

    @property
    def quaternion(self) -> np.ndarray:
        """The attitude of the axes (w into it, u, v) at every tick, (ticks, 4)."""
        return np.array([quaternion_from_rotation(R) for R in self._axes])[self._which]

    def normal(self, points: np.ndarray, time: np.ndarray) -> np.ndarray:
        """As `Surface.normal`."""
        R, local = self._local(points, time)
        return np.einsum("nij,nj->ni", R, self._surface.local_closest(local)[1])

    def signed_distance(self, points: np.ndarray, time: np.ndarray) -> np.ndarray:
        """As `Surface.signed_distance`; NaN while the surface is taken away."""
        _, local = self._local(points, time)
        foot, normal = self._surface.local_closest(local)
        gap = np.sum((local - foot) * normal, axis=-1)
        return np.where(self._there[self._ticks(time)], gap, np.nan)

    def trace(self, points: np.ndarray, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """As `Surface.trace`."""
        foot = self._surface.local_closest(self._local(points, time)[1])[0]
        return self._surface.unroll(foot[..., 1], foot[..., 2])

    def _ticks(self, time: np.ndarray) -> np.ndarray:
        return np.round(time / self._period).astype(int)

    def _local(self, points: np.ndarray, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Axes of the surface (n, 3, 3) and the points in them (n, 3)."""
        which = self._which[self._ticks(time)]
        R, origins = self._axes[which], self._origins[which]
        slid = self._surface.motion(time)[0][:, None] * self._surface.motion_axis
        return R, np.einsum("nji,nj->ni", R, points - origins - slid)
