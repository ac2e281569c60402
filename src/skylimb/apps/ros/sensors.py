"""From motion capture, IMU and joint states to a measurement: each checked, faults counted."""

from __future__ import annotations

import math
from collections import Counter
from typing import Any

import numpy as np

from skylimb.analysis.exchange.frames import Frames
from skylimb.analysis.exchange.lab_ticks import Names
from skylimb.analysis.exchange.lab_topics import IMU, JOINT_STATES, MOCAP, SERVO_STATES
from skylimb.analysis.exchange.messages import Imu, Joints, Pose, ServoStates
from skylimb.apps.ros.messages import Arrived
from skylimb.apps.ros.servos import Servos
from skylimb.base.bound_function import ArrayFunction
from skylimb.base.rotations import quaternion_from_rotation, rotation_from_quaternion, small_turn
from skylimb.control.estimation.gates import BEYOND
from skylimb.control.estimation.records import ABSENT, Measurement, Taken
from skylimb.control.estimation.records import Imu as Felt
from skylimb.control.estimation.stamps import Stamps, believed, judged
from skylimb.control.loop.vehicle import nothing_measured
from skylimb.robots.model import ImuPlace, Robot
from skylimb.symbolic import cross

JOINT_LOW_PASS = 2.0
"""Hz, of the joints' rates, which are differences of counts."""

LOW_PASS = 20.0
"""Hz, of the velocity that is made of stamped positions: the lab's own."""

OLDEST = 0.5
"""Seconds after which IMU or joint angles count as missing."""

SILENT = 0.05
"""Seconds without a gyro after which rates are differences of the attitudes that are seen."""

LOST = "imu too old"
"""Name of a fault: why a robot is led back that is seen."""

_TURNED = 10.0
"""Radians that no joint turns by."""


class Sensors:
    """Keeps the newest of each, and makes measurements of them.

    The motion capture shows the lab's link. Its velocity is the difference of stamped positions, low pass.
    Its rates are the IMU's, and where that is silent, differences of attitudes, low pass.
    Joints give the pose of the measured link, and their motion is taken off its
    rates and velocity. While no angles come that can be believed, those before them give it, and their age is
    handed on: a robot that feels no joints still sees where it is. Vectoring angles that nobody measures are
    the commanded ones.

    Args:
        robot: what flies.
        link: whose pose and rates come.
        servos: read `servo/states`; None where only `joint_states` come.
        names: of its joints.

    Attributes:
        has_imu: whether the IMU sits on that link, so that a measurement has what it says.
        counts: how often each fault was met.
    """

    def __init__(
        self, robot: Robot, link: str, servos: Servos | None = None, names: Names | None = None
    ) -> None:
        self._robot, self._servos = robot, servos
        self._names, self._frames = names or Names(robot), Frames(robot, link)
        self._imu_place = ArrayFunction(robot.imu_function)
        self._stamps = {Pose: Stamps(), Imu: Stamps(), Joints: Stamps()}
        self._pose: tuple[float, Pose] | None = None
        self._before: tuple[float, Pose] | None = None  # the newest when last asked
        self._imu: tuple[float, Imu] | None = None
        self._joints: tuple[float, np.ndarray] | None = None
        self._vectoring: np.ndarray | None = None
        self._bending = np.zeros(robot.n_joints + robot.n_vectoring)
        self.has_imu = robot.description.imu.link == link
        self._velocity, self._turning = np.zeros(3), np.zeros(3)
        self.counts: Counter[str] = Counter()

    def take(self, arrived: Arrived) -> None:
        """Take what a sensor says."""
        value: Any = arrived.value
        if isinstance(value, ServoStates) and self._servos is not None:
            angles = self._servos.angles(value.counts)
            value = Joints(value.stamp, tuple(angles), tuple(angles.values()))
        kind = type(value)
        if kind not in self._stamps:
            return
        self._stamps[kind], fault = judged(self._stamps[kind], value.stamp, arrived.at)
        taken = self._stamps[kind].taken
        if fault:
            self.counts[f"{arrived.topic}: {fault}"] += 1
        if not believed(fault):
            return
        if isinstance(value, Pose):
            self._pose = taken, value
            self._before = self._before or self._pose
        elif isinstance(value, Imu):
            if value.tells:
                self._imu = (taken, value)
            else:
                self.counts[f"{arrived.topic}: rates are no numbers"] += 1
        elif isinstance(value, Joints):
            self._bend(taken, value, arrived.topic)

    def measurement(self, now: float, commanded: np.ndarray) -> tuple[Measurement | None, Taken]:
        """The measurement of now and when its parts were taken; None while something has never come.

        Args:
            now: the pacer's time, s.
            commanded: vectoring angles, which stand in for measured ones, rad.
        """
        self._difference()
        if self._pose is None or self._imu is None or self._joints is None:
            return None, Taken()
        (seen, pose), (felt, joints) = self._pose, self._joints
        gyro = np.array(self._imu[1].gyro) if now - self._imu[0] <= SILENT else self._turning
        if self.lost(now):
            self.counts[LOST] += 1
        if now - felt > OLDEST:
            self.counts["joint angles too old"] += 1
            self._bending[:] = 0.0  # how fast they turn is not known any more
        vectoring = commanded if self._vectoring is None else self._vectoring
        return self._moved(pose, gyro, joints, vectoring)._replace(capture_age=now - seen), Taken(seen, felt)

    @property
    def missing(self) -> tuple[str, ...]:
        """Topics of which nothing has come yet that could be used."""
        joints = JOINT_STATES if self._servos is None else SERVO_STATES
        found = {MOCAP: self._pose, IMU: self._imu, joints: self._joints}
        return tuple(topic.name for topic, newest in found.items() if newest is None)

    @property
    def imu(self) -> Imu | None:
        """The newest of the flight controller's; None before the first one."""
        return None if self._imu is None else self._imu[1]

    def feels(self, now: float) -> bool:
        """Whether that is fresh, knows an attitude, and is that of the link that is seen."""
        if self._imu is None or not self.has_imu or now - self._imu[0] > SILENT:
            return False
        return abs(math.hypot(*self._imu[1].quaternion_xyzw) - 1.0) < 0.1

    def lost(self, now: float) -> str:
        """Why a robot has to be led back though it is seen; empty while nothing is."""
        return LOST if self._imu is not None and now - self._imu[0] > OLDEST else ""

    def _difference(self) -> None:
        """Velocity and rates of a new pose, from the newest one of the tick before.

        Those of a burst's last two poses are mostly noise, and would be flown by until the next burst comes.
        """
        if self._pose is not None and self._before is not None and self._pose is not self._before:
            (taken, pose), (before, last) = self._pose, self._before
            way = np.array(pose.position) - np.array(last.position)
            self._velocity = _differenced(self._velocity, way, taken - before, LOW_PASS)
            turn = small_turn(np.array(last.quaternion), np.array(pose.quaternion))
            self._turning = _differenced(self._turning, turn, taken - before, LOW_PASS)
        self._before = self._pose

    def _bend(self, taken: float, value: Joints, topic: str) -> None:
        """New joint angles, by name; without names in the robot's order."""
        names = value.names or (*self._names.joints, *self._names.gimbals)[: len(value.angles)]
        known = dict(zip(names, value.angles, strict=False))
        if len(names) != len(value.angles) or len(known) != len(names):
            self.counts[f"{topic}: wrong size"] += 1
        elif not set(self._names.joints) <= known.keys():
            self.counts[f"{topic}: wrong joint names"] += 1
        elif not all(
            abs(known.get(name, 0.0)) < _TURNED for name in (*self._names.joints, *self._names.gimbals)
        ):
            self.counts[f"{topic}: no angle"] += 1
        else:
            angles = np.array([known[name] for name in self._names.joints], dtype=float)
            if self._joints is not None:
                rates = self._bending[: len(angles)]
                self._bending[: len(angles)] = _differenced(
                    rates, angles - self._joints[1], taken - self._joints[0], JOINT_LOW_PASS
                )
            self._joints = (taken, angles)
            if set(self._names.gimbals) <= known.keys():
                self._vectoring = np.array([known[name] for name in self._names.gimbals], dtype=float)

    def _moved(self, pose: Pose, rates: np.ndarray, joints: np.ndarray, vectoring: np.ndarray) -> Measurement:
        """The measurement of the measured link; one that no watchdog believes where a number is none."""
        assert self._imu is not None
        gyro, force = np.array(self._imu[1].gyro), np.array(self._imu[1].acceleration)
        turn = np.array(pose.quaternion)
        size = float(np.sqrt(np.sum(np.clip(turn, -2.0, 2.0) ** 2)))
        sane = (np.abs(np.array([*gyro, *rates, *pose.position])) < BEYOND).all()
        if not (sane and abs(size - 1.0) < 0.1):
            nothing = nothing_measured(self._robot, self.has_imu)
            return nothing._replace(joint_angles=joints, vectoring_angles=vectoring)
        frames = self._frames.at(joints, vectoring)
        R = rotation_from_quaternion(turn / size) @ frames.R_root_link.T
        rates, moving, imu = frames.R_root_link @ rates, np.zeros(3), ABSENT
        mount = self._robot.description.imu
        if self.has_imu:
            place = ImuPlace(*self._imu_place(joints, vectoring, self._bending))
            rates, moving = rates - place.rates, place.velocity
            imu = Felt(mount.R.T @ gyro, mount.R.T @ force)
        velocity = self._velocity - R @ (cross(rates, frames.link) + moving)
        position, turn = np.array(pose.position) - R @ frames.link, quaternion_from_rotation(R)
        return Measurement(position, turn, velocity, rates, joints, vectoring, imu=imu)


def _differenced(rate: np.ndarray, way: np.ndarray, gap: float, cutoff: float) -> np.ndarray:
    """A rate after a way, behind a low pass (Hz); what is no number leaves it, the gates see to that."""
    part = 1.0 - math.exp(-2.0 * math.pi * cutoff * gap)
    with np.errstate(invalid="ignore", over="ignore"):
        moved = rate + part * (way / max(gap, 1e-3) - rate)
    return moved if np.isfinite(moved).all() else rate
