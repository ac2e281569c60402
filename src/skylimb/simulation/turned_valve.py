"""A valve whose lever turned in flight, as the analysis asks for it."""

from __future__ import annotations

import numpy as np

from skylimb.simulation.surfaces import Valve


class TurnedValve:
    """A valve with an angle at every tick; its methods are those of `Surface`, at the ticks' times.

    Args:
        valve: what turned.
        angle: of its hinge at every tick, rad, (ticks,).
        rate: of the angle, rad/s, (ticks,).
        tip: where the tip was, W, m, (ticks, 3); the lever's velocity is the one there.
        period: of a tick, s.
    """

    def __init__(
        self, valve: Valve, angle: np.ndarray, rate: np.ndarray, tip: np.ndarray, period: float
    ) -> None:
        self._valve, self._angle, self._period = valve, angle, period
        lever = tip - np.asarray(valve.position)
        self._velocity = rate[:, None] * np.cross(valve.R_WS[:, 0], lever)

    def velocity(self, time: np.ndarray) -> np.ndarray:
        """Of the lever where the tip is, W, m/s, (n, 3)."""
        return self._velocity[self._ticks(time)]

    def normal(self, points: np.ndarray, time: np.ndarray) -> np.ndarray:
        """As `Surface.normal`."""
        valve, angle = self._valve, self._angle[self._ticks(time)]
        return valve.closest_on_lever(valve.to_local(points), angle)[1] @ valve.R_WS.T

    def signed_distance(self, points: np.ndarray, time: np.ndarray) -> np.ndarray:
        """As `Surface.signed_distance`."""
        local, angle = self._valve.to_local(points), self._angle[self._ticks(time)]
        foot, normal = self._valve.closest_on_lever(local, angle)
        return np.sum((local - foot) * normal, axis=-1)

    def trace(self, points: np.ndarray, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Where the lever is touched: u and v of the valve's plane, in which it turns."""
        local, angle = self._valve.to_local(points), self._angle[self._ticks(time)]
        foot = self._valve.closest_on_lever(local, angle)[0]
        return foot[..., 1], foot[..., 2]

    def _ticks(self, time: np.ndarray) -> np.ndarray:
        return np.round(time / self._period).astype(int)
