"""What is believed of a robot that does not fly yet: the supervisor's gates, without its prediction."""

from __future__ import annotations

import functools

import numpy as np

from skylimb.base.packing import Layout, flattened
from skylimb.control.estimation.gates import FAULTS, angle_fault, pose_fault
from skylimb.control.estimation.records import Measurement, zero_measurement
from skylimb.control.supervisor.limits import Limits
from skylimb.flight.realtime.faults import Faults
from skylimb.robots.model import Robot


def shaped(robot: Robot, measurement: Measurement, imu: bool = False) -> Measurement | str:
    """A measurement as arrays of the robot's sizes, or what is wrong with it.

    Args:
        robot: gives the sizes.
        measurement: whatever came.
        imu: whether an IMU's part is needed; else it is left out.
    """
    sizes = _sizes(robot.n_joints, robot.n_vectoring, imu)
    try:
        parts = [np.asarray(part, dtype=float) for part in measurement.entries][: len(sizes.shapes)]
    except (TypeError, ValueError):
        return "no numbers"
    if [part.shape for part in parts] != list(sizes.shapes.values()):
        return "wrong size"
    return sizes.unpack(flattened(parts))


@functools.lru_cache(maxsize=16)
def _sizes(joints: int, vectoring: int, imu: bool) -> Layout[Measurement]:
    return Layout(zero_measurement(joints, vectoring, imu))


class Watchdog:
    """Judges measurements one after another, and remembers the last good one.

    Args:
        robot: gives the sizes of a measurement.
        limits: what is not believed.

    Attributes:
        good: the last measurement that was believed.
        fault: why the newest was not believed; empty where it was.
        counts: how often each fault was met.
    """

    def __init__(self, robot: Robot, limits: Limits | None = None) -> None:
        self._robot, self._limits = robot, limits or Limits()
        self.counts = Faults()
        self.good: Measurement | None = None
        self.fault = ""
        self._time = -np.inf  # of the last good one

    def forget(self) -> None:
        """Believe the next measurement whatever was believed before."""
        self.good, self._time = None, -np.inf

    def judge(self, measurement: Measurement | None, taken: float) -> None:
        """Take a measurement, or None where nothing new has come, that was taken at a time, s."""
        if measurement is None or not taken > self._time:
            return
        seen = shaped(self._robot, measurement)
        if isinstance(seen, str):
            self.fault = seen
            self.counts.note("watchdog", seen)
            return
        before = self.good or seen
        gone = taken - self._time if self.good else 0.0
        angles = np.concatenate([seen.joint_angles, seen.vectoring_angles])
        pose = pose_fault(self._limits, seen, before, gone, float(self.good is not None))
        self.fault = fault = FAULTS[int(pose or angle_fault(self._limits, angles))]
        if fault:
            self.counts.note("watchdog", fault)
        else:
            self.good, self._time = measurement, taken
