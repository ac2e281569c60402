"""Motion capture, IMU and joint states become a measurement; what is odd is counted and not used."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.analysis.exchange.frames import lab_link
from skylimb.apps.ros1.body import Bodies
from skylimb.apps.ros1.desk import Arrived, Desk
from skylimb.apps.ros1.lab_config import read_lab_config
from skylimb.apps.ros1.messages import Imu, Joints, Pose, ServoAngles
from skylimb.apps.ros1.outputs import Accelerometer, Names, Rates, frames, seen_by_sensors
from skylimb.apps.ros1.senses import Senses
from skylimb.base.rotations import rotation_from_quaternion
from skylimb.control.planning.posture import posture_family
from skylimb.control.planning.vectoring import vectoring_table
from skylimb.robots.description import GRAVITY
from steered import Steered

ROBOT = skylimb.load_robot("hydrus_xi_quad")
LINK = lab_link(ROBOT)
NAMES = Names(ROBOT)
LEVEL = (1.0, 0.0, 0.0, 0.0)
THETA = posture_family(ROBOT).theta_nominal
Q = np.asarray(posture_family(ROBOT).joint_angles(THETA), dtype=float)
PSI = np.asarray(vectoring_table(ROBOT, "torque").angles(THETA), dtype=float)
ALL = Joints(1.0, (*NAMES.joints, *NAMES.gimbals), (*Q.tolist(), *PSI.tolist()))


def told(senses: Senses, value: Any, at: float = 0.0, topic: str = "topic") -> None:
    senses.take(Arrived(topic, value, "/robot", at))


def ready_senses() -> Senses:
    senses = Senses(ROBOT, LINK)
    told(senses, Pose(1.0, (0.0, 0.0, 1.0), LEVEL))
    told(senses, Imu(1.0, LEVEL, (0.1, 0.2, 0.3)))
    told(senses, ALL)
    return senses


def test_what_the_sensors_show_becomes_what_was_measured() -> None:
    robot = Steered()
    robot.hover()
    robot.fly(0.5)
    measured = robot.plant.truth()
    body = Bodies(ROBOT, LINK).of(measured)
    senses = Senses(ROBOT, LINK)
    for topic, value in seen_by_sensors(0, 1.0, measured, body, (0.0, 0.0, 9.8), NAMES, Rates(0.005)):
        told(senses, value, 0.0, topic.name)
    found, taken = senses.measurement(0.0, PSI)
    assert found is not None
    assert taken == 0.0
    for name in ("position", "quaternion", "angular_velocity", "joint_angles", "vectoring_angles"):
        np.testing.assert_allclose(getattr(found, name), getattr(measured, name), atol=1e-9, err_msg=name)


def test_the_velocity_is_that_of_the_measured_link() -> None:
    senses = ready_senses()
    for k in range(1, 200):
        told(senses, Pose(1.0 + 0.01 * k, (0.005 * k, 0.0, 1.0), LEVEL), 0.01 * k)
        told(senses, Imu(1.0 + 0.01 * k, LEVEL, (0.0, 0.0, 0.0)), 0.01 * k)
        told(senses, Joints(1.0 + 0.01 * k, ALL.names, ALL.angles), 0.01 * k)
    found, taken = senses.measurement(2.0, PSI)
    assert found is not None
    np.testing.assert_allclose(found.velocity, [0.5, 0.0, 0.0], atol=1e-6)
    assert taken == pytest.approx(1.99)


def test_nothing_is_measured_before_all_have_spoken() -> None:
    senses = Senses(ROBOT, LINK)
    told(senses, Pose(1.0, (0.0, 0.0, 1.0), LEVEL))
    assert senses.measurement(0.0, PSI) == (None, -math.inf)


@pytest.mark.parametrize(
    ("value", "fault"),
    [
        (Pose(1.0, (9.0, 0.0, 1.0), LEVEL), "stamp repeated or out of order"),
        (Pose(0.5, (9.0, 0.0, 1.0), LEVEL), "stamp repeated or out of order"),
        (Pose(math.nan, (9.0, 0.0, 1.0), LEVEL), "stamp is no number"),
        (Pose(9.0, (9.0, 0.0, 1.0), LEVEL), "stamp from the future"),
        (Joints(1.1, ("joint1", "joint2"), (0.0, 0.0)), "wrong joint names"),
        (Joints(1.1, ("joint1", "joint1", "joint3"), (0.0, 0.0, 0.0)), "wrong size"),
        (Joints(1.1, ("joint1",), (0.0, 0.0)), "wrong size"),
    ],
)
def test_odd_messages_are_counted_and_change_nothing(value: Any, fault: str) -> None:
    senses = ready_senses()
    before = senses.measurement(0.0, PSI)
    told(senses, value, 0.1)
    assert senses.counts[f"topic: {fault}"] == 1
    after = senses.measurement(0.0, PSI)
    assert before[0] is not None
    assert after[0] is not None
    for one, other in zip(before[0], after[0], strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    "value",
    [
        Pose(1.1, (0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 0.0)),
        Pose(1.1, (0.0, 0.0, 1.0), (math.nan, 0.0, 0.0, 1.0)),
        Joints(1.1, NAMES.joints, (math.inf, 0.0, 0.0)),
    ],
)
def test_what_is_no_pose_is_left_to_the_watchdog(value: Any) -> None:
    senses = ready_senses()
    told(senses, value, 0.1)
    found, _ = senses.measurement(0.1, PSI)
    assert found is not None
    assert not np.isfinite(found.position).all()


def test_joints_without_names_and_gimbals_that_nobody_tells() -> None:
    senses = Senses(ROBOT, LINK)
    told(senses, Pose(1.0, (0.0, 0.0, 1.0), LEVEL))
    told(senses, Imu(1.0, LEVEL, (0.0, 0.0, 0.0)))
    told(senses, Joints(1.0, (), tuple(Q.tolist())))
    found, _ = senses.measurement(0.0, PSI + 0.25)
    assert found is not None
    np.testing.assert_array_equal(found.joint_angles, Q)
    np.testing.assert_array_equal(found.vectoring_angles, PSI + 0.25)


def test_old_joints_make_an_old_measurement() -> None:
    senses = ready_senses()
    told(senses, Pose(1.6, (0.0, 0.0, 1.0), LEVEL), 0.6)
    assert senses.measurement(0.6, PSI)[1] == 0.0
    assert senses.counts["imu or joint_states too old"] == 1


def test_of_each_sensor_only_the_first_sender_counts() -> None:
    heard: list[Arrived] = []
    desk = Desk(6, heard.append)
    desk.sort([Arrived("imu", 1, "/a", 0.0), Arrived("imu", 2, "/b", 0.0), Arrived("imu", 3, "/a", 0.0)])
    assert [one.value for one in heard] == [1, 3]
    assert desk.counts == {"second publisher of imu": 1}
    sorted_ = desk.sort(
        [Arrived("flight_config_cmd_ack", 1, "/a", 0.0), Arrived("skylimb/mission", "x", "/u", 0.0)]
    )
    assert (sorted_.acknowledged, sorted_.mission) == (1, "x")


def test_servos_are_read_in_their_own_counts() -> None:
    servos = read_lab_config([Path(__file__).parent / "lab" / "servo.yaml"], ROBOT).servos
    assert servos is not None
    senses = Senses(ROBOT, LINK, servos)
    told(senses, Pose(1.0, (0.0, 0.0, 1.0), LEVEL))
    told(senses, Imu(1.0, LEVEL, (0.0, 0.0, 0.0)))
    told(senses, servos.counts(ALL), topic="servo/states")
    found, _ = senses.measurement(0.0, np.zeros(4))
    assert found is not None
    np.testing.assert_allclose(found.joint_angles, Q, atol=0.0004)
    np.testing.assert_allclose(found.vectoring_angles, PSI, atol=0.0008)
    told(senses, ServoAngles(2.0, {0: 2047}), at=1.0, topic="servo/states")
    assert senses.counts["servo/states: wrong joint names"] == 1


def test_what_the_flight_controller_feels() -> None:
    robot = Steered()
    bodies, felt = Bodies(ROBOT, LINK), Accelerometer(0.005, GRAVITY)
    still = bodies.of(robot.plant.truth())
    np.testing.assert_allclose(np.linalg.norm(felt.of(still)), GRAVITY, rtol=1e-9)
    moved = still._replace(link_velocity=still.link_velocity + np.array([0.01, 0.0, -0.005 * GRAVITY]))
    np.testing.assert_allclose(still.R_W_link @ felt.of(moved), [2.0, 0.0, 0.0], atol=1e-9)


def test_frames_lead_from_the_world_to_the_centre_of_gravity() -> None:
    robot = Steered()
    robot.hover()
    body = Bodies(ROBOT, LINK).of(robot.plant.truth())
    world, root = frames(3.0, body, Names(ROBOT, "/other")).frames
    assert (world.parent, world.child, root.parent, root.child) == (
        *("world", "other/root"),
        *("other/root", "other/cog"),
    )
    R = np.asarray(rotation_from_quaternion(np.array(world.quaternion)))
    np.testing.assert_allclose(world.position + R @ root.position, body.cog, atol=1e-9)
    level = R @ rotation_from_quaternion(np.array(root.quaternion))
    assert np.arctan2(level[1, 0], level[0, 0]) == pytest.approx(body.yaw, abs=0.01)
