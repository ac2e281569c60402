"""What is believed of a measurement: fresh, finite, near the one before; else hold, then retreat."""

from __future__ import annotations

from collections.abc import Iterator
from enum import IntEnum
from typing import Annotated

import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.control.estimation.records import Measurement
from skylimb.flight.realtime.faults import Faults
from skylimb.robots.model import Robot

BEYOND = 1e9
"""No SI number that a robot measures is as large; NaN is not below it either."""


class State(IntEnum):
    """What is done at a tick."""

    FLY = 0
    HOLD = 1
    RETREAT = 2


@configuration
class Limits:
    """When a measurement is no longer believed."""

    hold_after: Annotated[
        float,
        Key("s", "age of the last good measurement above which the command is held", low=0.0, high=10.0),
    ] = 0.1
    retreat_after: Annotated[
        float, Key("s", "age above which the robot retreats and descends", low=0.0, high=60.0)
    ] = 0.5
    speed: Annotated[
        float, Key("m/s", "speed between two measurements above which one is a jump", above=0.0, high=1e3)
    ] = 10.0
    turning: Annotated[float, Key("rad/s", "the same of the attitude", above=0.0, high=1e3)] = 20.0
    angles: Annotated[
        float, Key("rad", "greatest size of a measured joint or vectoring angle", above=0.0, high=1e3)
    ] = 7.0
    overruns: Annotated[
        int, Key("", "ticks in a row without a new command after which the robot retreats", low=1, high=10**6)
    ] = 100


class Watchdog:
    """Judges measurements one after another, and remembers the last good one.

    Every kind of fault is counted, and named once in the log.

    Args:
        robot: gives the sizes of a measurement.
        limits: when a measurement is no longer believed.

    Attributes:
        good: the last measurement that was believed.
        counts: how often each fault was met.
    """

    def __init__(self, robot: Robot, limits: Limits | None = None) -> None:
        self._limits = limits or Limits()
        self._shapes = ((3,), (4,), (3,), (3,), (robot.n_joints,), (robot.n_vectoring,))
        self.counts = Faults()
        self.good: Measurement | None = None
        self._time = -np.inf  # of the last good one
        self._started: float | None = None

    def judge(self, measurement: Measurement | None, taken: float, now: float) -> State:
        """What is to be done with a measurement.

        Args:
            measurement: None where nothing new has come.
            taken: when it was taken, s, as `stamps.py` has it; a new one was taken later than the last good
                one.
            now: s, on the same clock.
        """
        if self._started is None:
            self._started = now
        fault = self._fault(measurement, taken)
        if fault:
            self.counts.note("watchdog", fault)
        elif measurement is not None and taken > self._time:
            self.good, self._time = measurement, taken
        age = now - max(self._time, self._started - self._limits.hold_after)
        if age > self._limits.retreat_after:
            self.counts.note("watchdog", "retreat")
            return State.RETREAT
        if age > self._limits.hold_after or self.good is None:
            self.counts.note("watchdog", "too old")
            return State.HOLD
        return State.FLY

    def _fault(self, measurement: Measurement | None, taken: float) -> str:
        """Why a measurement is not believed; empty where it is, or where there is none."""
        if measurement is None:
            return ""
        try:
            parts = [np.asarray(value, dtype=float) for value in measurement]
        except (TypeError, ValueError):
            return "no numbers"
        return next((name for name, wrong in self._checks(parts, taken) if wrong), "")

    def _checks(self, parts: list[np.ndarray], taken: float) -> Iterator[tuple[str, bool]]:
        """Faults in the order in which they are looked for; each relies on those before it being absent."""
        limits = self._limits
        yield "wrong size", tuple(part.shape for part in parts) != self._shapes
        yield "not finite", not all((abs(part) < BEYOND).all() for part in parts)
        yield "no attitude", abs(float(np.linalg.norm(parts[1])) - 1.0) > 0.1
        yield "angle out of range", max(np.abs(np.concatenate(parts[4:])), default=0.0) > limits.angles
        yield "too fast", bool(np.abs(parts[2]).max() > limits.speed)
        yield "too fast", bool(np.abs(parts[3]).max() > limits.turning)
        yield "jump", self._jumps(parts, taken)

    def _jumps(self, parts: list[np.ndarray], taken: float) -> bool:
        """Whether no robot comes from the last good pose to this one in the time between."""
        if self.good is None:
            return False
        # Two samples of one tick may differ by noise.
        elapsed = max(taken - self._time, 0.01)
        along = min(1.0, abs(float(np.dot(parts[1], self.good.quaternion))))
        way = float(np.linalg.norm(parts[0] - self.good.position))
        return way > self._limits.speed * elapsed or 2.0 * np.arccos(along) > self._limits.turning * elapsed
