"""How far off an IMU is while its robot rests: a wrong sign, unit or axis shows on the ground."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

import numpy as np

from skylimb.control.estimation.records import Imu

LATELY = 20
"""Samples that are looked at, the newest; their median, as a knock or one odd message says nothing."""


class ImuOff(NamedTuple):
    """How far off an IMU is.

    Attributes:
        force: its specific force beside gravity's, m/s^2.
        turning: its rates beside the robot's, rad/s.
    """

    force: float
    turning: float


class RestingImu:
    """Listens to an IMU.

    Args:
        gravity: m/s^2.
    """

    def __init__(self, gravity: float) -> None:
        self._rests = np.array([0.0, 0.0, gravity])
        self._heard: deque[np.ndarray] = deque(maxlen=LATELY)

    def take(self, R_W_imu: np.ndarray, rates: np.ndarray, imu: Imu) -> None:
        """Take what it says.

        Args:
            R_W_imu: its axes in W, by another sensor, (3, 3).
            rates: of the robot, by another sensor or as it stands, in the IMU's axes, rad/s, (3,).
            imu: what it says.
        """
        turning = np.linalg.norm(imu.angular_velocity - rates)
        self._heard.append(np.array([*(R_W_imu @ imu.specific_force), turning]))

    @property
    def off(self) -> ImuOff | None:
        """How far off it is; None where nothing was heard."""
        if not self._heard:
            return None
        *force, turning = np.median(np.array(self._heard), axis=0)
        return ImuOff(float(np.linalg.norm(force - self._rests)), float(turning))
