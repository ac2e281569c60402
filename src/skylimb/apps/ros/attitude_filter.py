"""The attitude that the lab's board believes in: gyro, corrected by accelerometer and compass.

Two vectors in the board's axes, up and north, are turned by the gyro and drawn towards what is felt: up at
every third pass where the specific force is near 1 g, north whenever the compass is new.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from skylimb.symbolic import cross

_UP, _NORTH, _EVERY = 600.0, 250.0, 3
"""Weights of what was believed against what is felt, and passes for one correction of up: the lab's."""

_STILL = 72.0, 133.0
"""Squares of the specific force, m^2/s^4, between which it is taken for gravity's."""


class AttitudeFilter(NamedTuple):
    """What it remembers: up (m/s^2) and the compass's field (gauss) in the board's axes, and its passes."""

    up: np.ndarray
    field: np.ndarray
    passes: int = 0

    @property
    def R(self) -> np.ndarray:
        """The board's axes in W, x north and z up, (3, 3)."""
        z = self.up / np.linalg.norm(self.up)
        west = cross(z, self.field)
        y = west / np.linalg.norm(west)
        return np.stack([cross(y, z), y, z])

    def after(self, rates: np.ndarray, force: np.ndarray, field: np.ndarray, dt: float) -> AttitudeFilter:
        """After a pass.

        Args:
            rates: rad/s, (3,).
            force: specific force, m/s^2, (3,).
            field: of the compass, (3,).
            dt: since the last pass, s.
        """
        turn = rates * dt
        up, seen = self.up + cross(self.up, turn), self.field + cross(self.field, turn)
        still = _STILL[0] < float(force @ force) < _STILL[1]
        if still and self.passes == 0:
            up = (_UP * up + force) / (_UP + 1.0)
        return AttitudeFilter(up, (_NORTH * seen + field) / (_NORTH + 1.0), (self.passes + still) % _EVERY)
