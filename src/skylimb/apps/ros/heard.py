"""What sensors tell beside what they measure: whether they are there, their clocks, whether it rests."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from skylimb.analysis.exchange.messages import Imu
from skylimb.apps.ros.messages import Arrived

STILL_FORCE, STILL_RATE = 0.3, 0.05
"""How far from gravity the specific force of a robot that rests may be, m/s^2, and how fast it may turn,
rad/s; one that sinks with 95 % of its weight feels 0.5 m/s^2 less."""


class Heard(NamedTuple):
    """Of one sensor after another.

    Attributes:
        at: when the newest message of each came, s.
        stamps: what it was stamped with, s.
        rests: since when the accelerometer has felt nothing but the ground, s.
    """

    at: dict[str, float] = {}  # noqa: RUF012 - never written into
    stamps: dict[str, float] = {}  # noqa: RUF012
    rests: float = math.inf

    def take(self, arrived: Arrived, gravity: float) -> Heard:
        """After a message."""
        value: Any = arrived.value
        if not hasattr(value, "stamp"):
            return self
        rests = self.rests
        if isinstance(value, Imu):
            felt, turns = float(np.linalg.norm(value.acceleration)), float(np.linalg.norm(value.gyro))
            still = abs(felt - gravity) < STILL_FORCE and turns < STILL_RATE
            rests = min(rests, arrived.at) if still else math.inf
        at, stamps = {**self.at, arrived.topic: arrived.at}, {**self.stamps, arrived.topic: value.stamp}
        return Heard(at, stamps, rests)

    def ages(self, now: float) -> dict[str, float]:
        """Of the newest message of each, s."""
        return {topic: now - at for topic, at in self.at.items()}

    def offsets(self, ours: float) -> dict[str, float]:
        """How far each clock is behind ours, s.

        Args:
            ours: from the pacer's time to the clock of our own stamps, s.
        """
        return {topic: self.at[topic] + ours - stamp for topic, stamp in self.stamps.items()}
