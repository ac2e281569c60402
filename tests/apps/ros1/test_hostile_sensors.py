"""Sensors of a robot gone wrong, by real bytes through the inbox of the profile `controller`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from skylimb.analysis.exchange import lab_topics as topics
from skylimb.analysis.exchange.codec import message_of
from skylimb.analysis.exchange.frames import lab_link
from skylimb.analysis.exchange.lab_ticks import Names
from skylimb.analysis.exchange.lab_topics import Topic
from skylimb.analysis.exchange.message_types import Definitions
from skylimb.analysis.exchange.messages import Imu, Joints, Pose
from skylimb.apps.ros.controlled import Controlled
from skylimb.apps.ros.flyer import Flyer
from skylimb.apps.ros.inbox import Inbox, Raw
from skylimb.apps.ros.profile import profile_topics
from skylimb.flight.realtime.pacer import Pacer
from steered import ready

LEVEL = (1.0, 0.0, 0.0, 0.0)
START = 1e9


class Sensed:
    """The profile `controller`, fed at 100 Hz with a robot that stands, its messages spoiled or not."""

    def __init__(self, definitions: Definitions) -> None:
        self.definitions, self.takes = definitions, dict[str, Callable[[Raw], None]]()
        self.time, self.k = 0, 0
        heard = profile_topics("controller").subscribed
        self.inbox = Inbox(heard, definitions, "hydrus_xi", lambda: 1e-9 * self.time, self._add)
        takeoff, controller = ready("hybrid")
        robot = takeoff.robot
        self.pacer = Pacer(takeoff.period, lambda: self.time, self._sleep, spin=0.0)
        missions = {"paper": takeoff.mission}
        self.profile = Controlled(Flyer(takeoff, controller, missions, lab_link(robot), self.pacer))
        names, first = Names(robot), takeoff.mission.first
        angles = (*np.asarray(first.joint_angles).tolist(), *np.asarray(first.vectoring_angles).tolist())
        self.joints = Joints(0.0, (*names.joints, *names.gimbals), angles)
        self.pacer.start()

    def _add(self, name: str, take: Callable[[Raw], None]) -> None:
        self.takes[name] = take

    def _sleep(self, seconds: float) -> None:
        self.time += round(seconds * 1e9)

    def send(self, topic: Topic, value: Any, sender: str = "/robot") -> None:
        types = self.definitions.types
        data = bytes(types.serialize_ros1(message_of(types, topic.type, value), topic.type))
        name, digest, _ = self.definitions.described(topic.type)
        self.takes[topic.full("hydrus_xi")](Raw(data, digest, name, sender, 0.0))

    def tick(self, spoil: Callable[[Any], Any] = lambda value: value, sender: str = "/robot") -> None:
        self.pacer.wait(self.k)
        if self.k % 2 == 0:
            stamp = START + self.pacer.time()
            for topic, value in (
                (topics.MOCAP, Pose(stamp, (0.0, 0.0, 0.2), LEVEL)),
                (topics.IMU, Imu(stamp, (0.0, 0.0, 0.0))),
                (topics.JOINT_STATES, replace(self.joints, stamp=stamp)),
            ):
                self.send(topic, spoil(value), sender)
        self.profile.tick(self.inbox.take(), START + self.pacer.time())
        self.k += 1


def only(kind: type, **changes: Any) -> Callable[[Any], Any]:
    return lambda value: replace(value, **changes) if isinstance(value, kind) else value


@pytest.fixture(scope="module")
def sensed(definitions: Definitions) -> Sensed:
    robot = Sensed(definitions)
    for _ in range(20):
        robot.tick()
    assert not robot.profile.faults
    return robot


@pytest.mark.parametrize(
    ("spoil", "fault"),
    [
        (only(Pose, position=(math.nan, 0.0, 0.2)), "not finite"),
        (only(Pose, quaternion=(0.0, 0.0, 0.0, 0.0)), "not finite"),
        (only(Pose, position=(50.0, 0.0, 0.2)), "too fast"),
        (only(Pose, quaternion=(0.0, 1.0, 0.0, 0.0)), "jump"),
        (only(Pose, stamp=START - 5.0), "mocap/pose: stamp repeated or out of order"),
        (only(Pose, stamp=START + 500.0), "mocap/pose: stamp from the future"),
        (only(Imu, gyro=(500.0, 0.0, 0.0)), "too fast"),
        (only(Imu, gyro=(math.inf, 0.0, 0.0)), "imu: rates are no numbers"),
        (only(Joints, names=("a", "b", "c", "d", "e", "f", "g")), "joint_states: wrong joint names"),
        (only(Joints, angles=(0.0,)), "joint_states: wrong size"),
        (only(Joints, angles=(math.nan,) * 7), "joint_states: no angle"),
    ],
)
def test_a_spoiled_sensor_is_counted_and_forgotten(
    sensed: Sensed, spoil: Callable[[Any], Any], fault: str
) -> None:
    before = sensed.profile.faults[fault]
    for _ in range(4):
        sensed.tick(spoil)
    assert sensed.profile.faults[fault] > before
    for _ in range(40):  # fresh ones are believed again
        sensed.tick()
    last = sensed.profile.last
    assert last is not None
    assert last.body is not None
    assert np.linalg.norm(last.body.link - [0.0, 0.0, 0.2]) < 0.01
    assert not last.motors


def test_a_second_publisher_of_the_pose_is_not_listened_to(sensed: Sensed) -> None:
    for _ in range(4):
        sensed.tick(only(Pose, position=(9.0, 0.0, 0.2)), "/other")
    faults = sensed.profile.faults
    for topic in ("mocap/pose", "imu", "joint_states"):
        assert faults[f"second publisher of {topic}"] >= 2
    for _ in range(10):
        sensed.tick()
    last = sensed.profile.last
    assert last is not None
    assert last.body is not None
    assert abs(last.body.link[0]) < 0.01
