"""What the flight controller of a simulated robot feels."""

from __future__ import annotations

import numpy as np

from skylimb.analysis.exchange.body import Body
from skylimb.analysis.exchange.lab_messages import vector
from skylimb.analysis.exchange.messages import Vector


class Accelerometer:
    """The acceleration of the lab's link without gravity's share.

    Args:
        period: between two looks, s.
        gravity: of the place, m/s^2.
    """

    def __init__(self, period: float, gravity: float) -> None:
        self._period, self._gravity = period, np.array([0.0, 0.0, gravity])
        self._velocity: np.ndarray | None = None

    def of(self, body: Body) -> Vector:
        """Mean since the last look, in the link's axes, m/s^2; at rest gravity upward."""
        before = body.link_velocity if self._velocity is None else self._velocity
        self._velocity = body.link_velocity
        felt = (body.link_velocity - before) / self._period + self._gravity
        return vector(body.R_W_link.T @ felt)
