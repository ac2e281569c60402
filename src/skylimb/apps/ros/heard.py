"""What sensors tell beside what they measure: whether they are there, their clocks, whether it rests."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from skylimb.analysis.exchange.lab_topics import MOCAP
from skylimb.analysis.exchange.messages import Imu
from skylimb.apps.ros.messages import Arrived

STILL_FORCE, STILL_RATE = 0.3, 0.05
"""How far from gravity the specific force of a robot that rests may be, m/s^2, and how fast it may turn,
rad/s; one that sinks with 95 % of its weight feels 0.5 m/s^2 less. One that hovers, or sinks evenly, feels
the same: who asks has to know that the rotors do not carry it."""

SMOOTH, LONGEST = 0.1, 1.0
"""Share of a new gap between frames in their mean; seconds beyond which it is none, but a silence or a clock
that was set."""

SILENT = 0.1
"""Seconds after which an accelerometer that says nothing new says nothing any more."""


class Heard(NamedTuple):
    """Of one sensor after another.

    Attributes:
        at: when the newest message of each came, s.
        stamps: what it was stamped with, s.
        gap: between two frames of the motion capture, by their stamps, s, smoothed; NaN before the second.
        felt: when an accelerometer was heard last, s.
        rests: since when it has felt its weight and nothing else, s.
    """

    at: dict[str, float] = {}  # noqa: RUF012 - never written into
    stamps: dict[str, float] = {}  # noqa: RUF012
    gap: float = math.nan
    felt: float = -math.inf
    rests: float = math.inf

    def take(self, arrived: Arrived, gravity: float) -> Heard:
        """After a message."""
        value: Any = arrived.value
        if not hasattr(value, "stamp") or (isinstance(value, Imu) and not value.tells):
            return self
        at, stamps = {**self.at, arrived.topic: arrived.at}, {**self.stamps, arrived.topic: value.stamp}
        heard = self._replace(at=at, stamps=stamps, gap=self._gap_with(arrived))
        if not isinstance(value, Imu):
            return heard
        size, turns = float(np.linalg.norm(value.acceleration)), float(np.linalg.norm(value.gyro))
        still = abs(size - gravity) < STILL_FORCE and turns < STILL_RATE
        # Nobody knows what it felt while it was silent.
        since = self.rests if arrived.at - self.felt <= SILENT else arrived.at
        rests = min(since, arrived.at) if still else math.inf
        return heard._replace(felt=arrived.at, rests=rests)

    def _gap_with(self, arrived: Arrived) -> float:
        """The gap with one more message; one that is no gap of a stream leaves it."""
        if arrived.topic != MOCAP.name or MOCAP.name not in self.stamps:
            return self.gap
        gap: float = arrived.value.stamp - self.stamps[MOCAP.name]
        if not 0.0 < gap < LONGEST:
            return self.gap
        return gap if math.isnan(self.gap) else self.gap + SMOOTH * (gap - self.gap)

    @property
    def rate(self) -> float:
        """Of the motion capture, Hz; NaN before its second frame."""
        return 1.0 / self.gap

    def rest(self, now: float) -> float:
        """For how long the accelerometer has felt its weight and nothing else, s; 0 while it is silent."""
        return max(0.0, now - self.rests) if now - self.felt <= SILENT else 0.0

    def ages(self, now: float) -> dict[str, float]:
        """Of the newest message of each, s."""
        return {topic: now - at for topic, at in self.at.items()}

    def offsets(self, ours: float) -> dict[str, float]:
        """How far each clock is behind ours, s.

        Args:
            ours: from the pacer's time to the clock of our own stamps, s.
        """
        return {topic: self.at[topic] + ours - stamp for topic, stamp in self.stamps.items()}
