"""From a tick to the messages that anybody may look at, each at its own rate."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from skylimb.apps.ros1 import topics
from skylimb.apps.ros1.body import Body
from skylimb.apps.ros1.messages import (
    WORLD,
    Axis,
    Diagnosis,
    FourAxes,
    Imu,
    Joints,
    Odometry,
    Pose,
    PoseControl,
    Transform,
    Transforms,
    Turn,
    Vector,
    Wrench,
)
from skylimb.apps.ros1.tick import Tick
from skylimb.apps.ros1.topics import Topic
from skylimb.base.rotations import rot_z, rpy_from_rotation
from skylimb.control.estimation.records import Measurement
from skylimb.control.missions.reference import Reference
from skylimb.robots.model import Robot

_FORCE, _TORQUE = "external_force_estimate", "external_torque_estimate"


class Outgoing(NamedTuple):
    """A message that is to be published."""

    topic: Topic
    value: Any


class Rates:
    """Which topics are due at a tick.

    Args:
        period: of the ticks, s.
    """

    def __init__(self, period: float) -> None:
        self._period = period

    def due(self, topic: Topic, k: int) -> bool:
        """Whether a topic is published at tick `k`: at its own rate, or at that of the ticks."""
        every = 1 if topic.rate <= 0.0 else max(1, round(1.0 / (topic.rate * self._period)))
        return k % every == 0


class Names:
    """Names of a robot's joints on the lab's topics.

    Args:
        robot: whose. Our `gimbal_jointN` is the lab's `gimbalN`, with the same zero and axis.
        namespace: of the lab's topics, and of its frames.
    """

    def __init__(self, robot: Robot, namespace: str = topics.NAMESPACE) -> None:
        description, self._namespace = robot.description, namespace.strip("/")
        self.joints = description.shape_joints
        self.gimbals = tuple(name.replace("gimbal_joint", "gimbal") for name in description.vectoring_joints)

    def frame(self, name: str) -> str:
        """A frame of the robot, as the lab calls it."""
        return f"{self._namespace}/{name}"

    def joint_states(self, stamp: float, measured: Measurement) -> Joints:
        """Joints and gimbals as measured."""
        angles = (*_floats(measured.joint_angles), *_floats(measured.vectoring_angles))
        return Joints(stamp, (*self.joints, *self.gimbals), angles)


class Accelerometer:
    """What the flight controller feels: the acceleration of the lab's link without gravity's share.

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
        return _vector(body.R_W_link.T @ felt)


def seen_by_sensors(
    k: int,
    stamp: float,
    measured: Measurement,
    body: Body,
    acceleration: Vector,
    names: Names,
    rates: Rates,
) -> Iterator[Outgoing]:
    """What motion capture, the flight controller and the servos tell of a simulated robot."""
    turn = _turn(body.R_W_link)
    if rates.due(topics.MOCAP, k):
        yield Outgoing(topics.MOCAP, Pose(stamp, _vector(body.link), turn))
    if rates.due(topics.IMU, k):
        yield Outgoing(topics.IMU, Imu(stamp, turn, _vector(body.rates_link), acceleration))
    if rates.due(topics.JOINT_STATES, k):
        yield Outgoing(topics.JOINT_STATES, names.joint_states(stamp, measured))


def seen_by_anybody(k: int, stamp: float, tick: Tick, names: Names, rates: Rates) -> Iterator[Outgoing]:
    """State, odometry and frames, targets and errors, and the estimated wrench."""
    if rates.due(topics.STATE, k):
        yield Outgoing(topics.STATE, tick.flying.shown)
    body = tick.body
    if body is None:
        return
    if rates.due(topics.COG, k):
        R = lab_cog(body)
        turning = R.T @ (body.R_WC @ body.rates_cog)
        name = names.frame("cog")
        yield Outgoing(topics.COG, _odometry(stamp, name, body.cog, R, body.velocity, turning))
    if rates.due(topics.BASELINK, k):
        yield Outgoing(
            topics.BASELINK,
            _odometry(
                stamp, names.frame("fc"), body.link, body.R_W_link, body.link_velocity, body.rates_link
            ),
        )
    if rates.due(topics.TF, k):
        yield Outgoing(topics.TF, frames(stamp, body, names))
    if tick.reference is not None and rates.due(topics.PID, k):
        yield Outgoing(topics.PID, _control(stamp, body, tick.reference))
    if _FORCE in tick.signals and rates.due(topics.WRENCH, k):
        force, torque = tick.signals[_FORCE], tick.signals[_TORQUE]
        yield Outgoing(topics.WRENCH, Wrench(stamp, _vector(force), _vector(torque)))


def lab_cog(body: Body) -> np.ndarray:
    """The lab's axes at the centre of gravity, in W: level like C, with the yaw of its link."""
    return body.R_WC @ np.asarray(rot_z(body.yaw_in_C))


def frames(stamp: float, body: Body, names: Names) -> Transforms:
    """The robot's root in the world and the centre of gravity in the root, as the lab's own nodes tell."""
    root, cog = names.frame("root"), names.frame("cog")
    turn = body.R_W_root.T
    there = _vector(turn @ (body.cog - body.root))
    return Transforms(
        (
            Transform(stamp, WORLD, root, _vector(body.root), _turn(body.R_W_root)),
            Transform(stamp, root, cog, there, _turn(turn @ lab_cog(body))),
        )
    )


def commanded(k: int, stamp: float, tick: Tick, names: Names, rates: Rates) -> Iterator[Outgoing]:
    """What the robot is to do."""
    if tick.flying.arming is not None and rates.due(topics.CONFIG, k):
        yield Outgoing(topics.CONFIG, int(tick.flying.arming))
    if tick.motors and rates.due(topics.FOUR_AXES, k):
        thrusts = FourAxes((0.0, 0.0, 0.0), _floats(tick.command.thrusts))
        yield Outgoing(topics.FOUR_AXES, thrusts)
    if rates.due(topics.GIMBALS_CTRL, k):
        angles = _floats(tick.command.vectoring_angles)
        yield Outgoing(topics.GIMBALS_CTRL, Joints(stamp, names.gimbals, angles))


def diagnosis(
    tick: Tick, faults: Mapping[str, int], news: Mapping[str, int], more: Mapping[str, str]
) -> Diagnosis:
    """How it goes, once a second.

    Args:
        tick: the last one.
        faults: all so far, by name.
        news: those of the last second.
        more: anything else to tell.
    """
    state = "FORCE_LANDING" if tick.flying.force_landing else tick.flying.state.name
    values = {"flight_state": state, **more, **{name: str(count) for name, count in sorted(faults.items())}}
    if tick.flying.force_landing or tick.flying.low_battery:
        words = "force landing" if tick.flying.force_landing else "low battery"
        return Diagnosis(2, words, values)
    if news:
        return Diagnosis(1, ", ".join(f"{name} ({count})" for name, count in sorted(news.items())), values)
    return Diagnosis(0, state, values)


def _control(stamp: float, body: Body, reference: Reference) -> PoseControl:
    """Targets and errors; the heading's error stands for that of the yaw."""
    place, speed = np.asarray(reference.position), np.asarray(reference.velocity)
    axes = [
        Axis(float(a), float(a - b), float(c), float(c - d))
        for a, b, c, d in zip(place, body.cog, speed, body.velocity, strict=True)
    ]
    roll, pitch, yaw = _floats(rpy_from_rotation(body.R_WC))
    x, y, z = axes
    return PoseControl(stamp, (x, y, z, Axis(0.0, -roll), Axis(0.0, -pitch), Axis(yaw, 0.0)))


def _odometry(
    stamp: float, frame: str, position: np.ndarray, R: np.ndarray, velocity: np.ndarray, rates: np.ndarray
) -> Odometry:
    return Odometry(stamp, frame, _vector(position), _turn(R), _vector(velocity), _vector(rates))


def _vector(values: Any) -> Vector:
    x, y, z = _floats(values)
    return x, y, z


def _turn(R: np.ndarray) -> Turn:
    """Quaternion of a rotation matrix: the largest of its parts decides which formula is exact."""
    (a, b, c), (d, e, f), (g, h, i) = R.tolist()
    squares = (1 + a + e + i, 1 + a - e - i, 1 - a + e - i, 1 - a - e + i)
    best = max(range(4), key=squares.__getitem__)
    parts = (
        (squares[0], h - f, c - g, d - b),
        (h - f, squares[1], b + d, c + g),
        (c - g, b + d, squares[2], f + h),
        (d - b, c + g, f + h, squares[3]),
    )[best]
    size = 2.0 * math.sqrt(squares[best])
    w, x, y, z = (part / size for part in parts)
    return (w, x, y, z) if w >= 0.0 else (-w, -x, -y, -z)


def _floats(values: Any) -> tuple[float, ...]:
    return tuple(np.ravel(values).tolist())
