"""Motion capture, IMU and joint states become a measurement; what is odd is counted and not used."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.analysis.exchange.body import Bodies
from skylimb.analysis.exchange.frames import Frames, lab_link
from skylimb.analysis.exchange.lab_messages import full_state, mounts, transforms
from skylimb.analysis.exchange.lab_ticks import Names, TickView
from skylimb.analysis.exchange.lab_topics import IMU, JOINT_STATES, MOCAP
from skylimb.analysis.exchange.messages import Imu, Joints, Pose, ServoStates
from skylimb.apps.ros.lab_config import read_lab_config
from skylimb.apps.ros.messages import Arrived, published
from skylimb.apps.ros.sensors import Sensors
from skylimb.apps.ros.sorting import MessageSorter
from skylimb.base.rotations import quaternion_product, rotation_from_quaternion
from skylimb.control.planning.posture import posture_family
from skylimb.control.planning.vectoring import vectoring_table
from skylimb.robots.description import GRAVITY
from steered import in_hover

ROBOT = skylimb.load_robot("hydrus_xi_quad")
LINK = lab_link(ROBOT)
NAMES = Names(ROBOT)
LEVEL = (1.0, 0.0, 0.0, 0.0)
THETA = posture_family(ROBOT).theta_nominal
Q = np.asarray(posture_family(ROBOT).joint_angles(THETA), dtype=float)
PSI = np.asarray(vectoring_table(ROBOT, "torque").angles(THETA), dtype=float)
ALL = Joints(1.0, (*NAMES.joints, *NAMES.gimbals), (*Q.tolist(), *PSI.tolist()))


def hear(sensors: Sensors, value: Any, at: float = 0.0, topic: str = "topic") -> None:
    sensors.take(Arrived(topic, value, "/robot", at))


def ready_sensors() -> Sensors:
    sensors = Sensors(ROBOT, LINK)
    hear(sensors, Pose(1.0, (0.0, 0.0, 1.0), LEVEL))
    hear(sensors, Imu(1.0, (0.1, 0.2, 0.3)))
    hear(sensors, ALL)
    return sensors


def test_what_the_sensors_show_becomes_what_was_measured() -> None:
    robot = in_hover()
    robot.fly(0.5)
    measured = robot.plant.truth()
    body = Bodies(ROBOT, LINK).of(measured)
    sensors = Sensors(ROBOT, LINK)
    view = TickView(1.0, NAMES, body, np.concatenate(measured[4:6]))
    for topic, value in published((MOCAP, IMU, JOINT_STATES), view, 0, 0.005):
        hear(sensors, value, 0.0, topic.name)
    found, taken = sensors.measurement(0.0, PSI)
    assert found is not None
    assert taken == (0.0, 0.0)
    for name in ("position", "quaternion", "angular_velocity", "joint_angles", "vectoring_angles"):
        np.testing.assert_allclose(getattr(found, name), getattr(measured, name), atol=1e-9, err_msg=name)


def test_poses_that_come_in_bursts_say_the_velocity_of_their_way_and_not_of_their_noise() -> None:
    """Frames that a network holds for 40 ms: by the last two of them a robot in hover swung by 8 cm."""
    sensors, noise, found = ready_sensors(), np.random.default_rng(0), list[float]()
    for burst in range(1, 50):
        now = 0.04 * burst
        for k in range(4 * burst - 3, 4 * burst + 1):
            place = 0.001 * noise.standard_normal(3) + (0.0, 0.0, 1.0)
            hear(sensors, Pose(1.0 + 0.01 * k, (place[0], place[1], place[2]), LEVEL), now)
        hear(sensors, Imu(1.0 + now, (0.0, 0.0, 0.0)), now)
        hear(sensors, Joints(1.0 + now, ALL.names, ALL.angles), now)
        measured, _ = sensors.measurement(now, PSI)
        assert measured is not None
        found.append(float(measured.velocity[0]))
    assert float(np.std(found)) < 0.05  # 0.09 by the last two


def test_the_velocity_is_that_of_the_measured_link() -> None:
    sensors = ready_sensors()
    for k in range(1, 200):
        hear(sensors, Pose(1.0 + 0.01 * k, (0.005 * k, 0.0, 1.0), LEVEL), 0.01 * k)
        hear(sensors, Imu(1.0 + 0.01 * k, (0.0, 0.0, 0.0)), 0.01 * k)
        hear(sensors, Joints(1.0 + 0.01 * k, ALL.names, ALL.angles), 0.01 * k)
    found, taken = sensors.measurement(2.0, PSI)
    assert found is not None
    np.testing.assert_allclose(found.velocity, [0.5, 0.0, 0.0], atol=1e-6)
    assert taken == pytest.approx((1.99, 1.99))


def test_nothing_is_measured_before_all_have_spoken() -> None:
    sensors = Sensors(ROBOT, LINK)
    hear(sensors, Pose(1.0, (0.0, 0.0, 1.0), LEVEL))
    assert sensors.measurement(0.0, PSI) == (None, (-math.inf, -math.inf))


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
        (Joints(1.1, NAMES.joints, (math.inf, 0.0, 0.0)), "no angle"),
        (Joints(1.1, NAMES.joints, (0.0, math.nan, 0.0)), "no angle"),
        (Joints(1.1, ALL.names, (*Q.tolist(), 0.0, 0.0, 11.0, 0.0)), "no angle"),
        (Imu(1.1, (math.nan, 0.0, 0.0)), "rates are no numbers"),
    ],
)
def test_odd_messages_are_counted_and_change_nothing(value: Any, fault: str) -> None:
    sensors = ready_sensors()
    before = sensors.measurement(0.0, PSI)
    hear(sensors, value, 0.1)
    assert sensors.counts[f"topic: {fault}"] == 1
    after = sensors.measurement(0.0, PSI)
    assert before[0] is not None
    assert after[0] is not None
    for one, other in zip(before[0], after[0], strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    "value",
    [
        Pose(1.1, (0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 0.0)),
        Pose(1.1, (0.0, 0.0, 1.0), (math.nan, 0.0, 0.0, 1.0)),
    ],
)
def test_what_is_no_pose_is_left_to_the_watchdog(value: Any) -> None:
    sensors = ready_sensors()
    hear(sensors, value, 0.1)
    found, _ = sensors.measurement(0.1, PSI)
    assert found is not None
    assert not np.isfinite(found.position).all()


def test_joints_without_names_and_gimbals_that_nobody_measures() -> None:
    sensors = Sensors(ROBOT, LINK)
    hear(sensors, Pose(1.0, (0.0, 0.0, 1.0), LEVEL))
    hear(sensors, Imu(1.0, (0.0, 0.0, 0.0)))
    hear(sensors, Joints(1.0, (), tuple(Q.tolist())))
    found, _ = sensors.measurement(0.0, PSI + 0.25)
    assert found is not None
    np.testing.assert_array_equal(found.joint_angles, Q)
    np.testing.assert_array_equal(found.vectoring_angles, PSI + 0.25)


def test_an_old_gyro_and_old_joints_make_no_old_pose() -> None:
    """It is known with the angles that were believed last; who has lost a sensor is led back in sight."""
    sensors = ready_sensors()
    hear(sensors, Pose(1.6, (0.0, 0.0, 1.0), LEVEL), 0.6)
    assert sensors.lost(0.5) == ""
    assert sensors.lost(0.6) == "imu too old"
    found, taken = sensors.measurement(0.6, PSI)
    assert taken == pytest.approx((0.6, 0.0))
    assert sensors.counts == {"imu too old": 1, "joint angles too old": 1}
    assert found is not None
    np.testing.assert_array_equal(found.joint_angles, Q)
    assert np.isfinite(found.position).all()
    hear(sensors, Imu(1.6, (0.0, 0.0, 0.0)), 0.6)
    assert sensors.lost(0.6) == ""


def test_without_a_gyro_rates_are_differences_of_attitudes() -> None:
    """A turn of 0.5 rad/s about the link's own x axis, of a robot that leans, seen at 100 Hz."""
    sensors = ready_sensors()
    lean = np.array([np.cos(0.1), 0.0, np.sin(0.1), 0.0])
    for k in range(1, 60):
        half = 0.5 * 0.5 * 0.01 * k
        turn = quaternion_product(lean, np.array([np.cos(half), np.sin(half), 0.0, 0.0]))
        sign = 1.0 if k % 2 else -1.0  # both are the same attitude
        hear(sensors, Pose(1.0 + 0.01 * k, (0.0, 0.0, 1.0), tuple(sign * turn)), 0.01 * k)
        hear(sensors, Joints(1.0 + 0.01 * k, ALL.names, ALL.angles), 0.01 * k)
        sensors.measurement(0.01 * k, PSI)
    found, _ = sensors.measurement(0.59, PSI)
    assert found is not None
    R = Frames(ROBOT, LINK).at(Q, PSI).R_root_link
    np.testing.assert_allclose(R.T @ found.angular_velocity, [0.5, 0.0, 0.0], atol=1e-3)
    hear(sensors, Imu(1.59, (0.1, 0.2, 0.3)), 0.59)
    found, _ = sensors.measurement(0.59, PSI)
    assert found is not None
    np.testing.assert_allclose(R.T @ found.angular_velocity, [0.1, 0.2, 0.3], atol=1e-9)


def test_of_each_sensor_one_sender_counts() -> None:
    heard: list[Arrived] = []
    sorter = MessageSorter(6, heard.append)
    sorter.sort([Arrived("imu", 1, "/a", 0.0), Arrived("imu", 2, "/b", 0.0), Arrived("imu", 3, "/a", 0.0)])
    assert [one.value for one in heard] == [1, 3]
    assert sorter.counts == {"second publisher of imu": 1}
    sorted_ = sorter.sort(
        [Arrived("flight_config_ack", 1, "/a", 0.0), Arrived("skylimb/mission", "x", "/u", 0.0)]
    )
    assert (sorted_.acknowledged, sorted_.mission) == (1, "x")


def test_a_sensor_that_is_started_anew_is_listened_to_once_the_first_is_silent() -> None:
    """Its name is another one: on ROS 2 always, on ROS 1 of an anonymous node."""
    heard: list[Arrived] = []
    sorter = MessageSorter(6, heard.append)
    for k in range(100):
        both = [Arrived("mocap/pose", k, name, 0.01 * k) for name in ("/a", "/b")]
        sorter.sort(both if k < 20 else both[1:])
    assert [one.sender for one in heard] == ["/a"] * 20 + ["/b"] * 60  # 0.2 s later
    assert sorter.counts == {
        "second publisher of mocap/pose": 40,
        "another publisher of mocap/pose is listened to": 1,
    }
    acknowledged = [
        sorter.sort([Arrived("flight_config_ack", 1, name, at)]).acknowledged
        for name, at in (("/a", 0.0), ("/b", 1.0), ("/b", 2.1))
    ]
    assert acknowledged == [1, None, 1]


def test_servos_are_read_in_their_own_counts() -> None:
    servos = read_lab_config([Path(__file__).parent / "lab" / "servo.yaml"], ROBOT).servos
    assert servos is not None
    sensors = Sensors(ROBOT, LINK, servos)
    hear(sensors, Pose(1.0, (0.0, 0.0, 1.0), LEVEL))
    hear(sensors, Imu(1.0, (0.0, 0.0, 0.0)))
    counts = servos.counts(dict(zip(ALL.names, ALL.angles, strict=True)))
    hear(sensors, ServoStates(1.0, tuple(counts.items())), topic="servo/states")
    found, _ = sensors.measurement(0.0, np.zeros(4))
    assert found is not None
    np.testing.assert_allclose(found.joint_angles, Q, atol=0.0004)
    np.testing.assert_allclose(found.vectoring_angles, PSI, atol=0.0008)
    hear(sensors, ServoStates(2.0, ((0, 2047),)), at=1.0, topic="servo/states")
    assert sensors.counts["servo/states: wrong joint names"] == 1


def test_the_joints_motion_is_taken_off_and_what_the_imu_says_is_handed_on() -> None:
    """Joint 1 turns at 0.2 rad/s below a flight controller that stands still: link 1 turns the other way."""
    sensors, still = Sensors(ROBOT, LINK), np.array([0.0, 0.0, GRAVITY])
    for k in range(200):
        at, bent = 0.02 * k, Q + np.array([0.004 * k, 0.0, 0.0])
        hear(sensors, Pose(1.0 + at, (0.0, 0.0, 1.0), LEVEL), at)
        hear(sensors, Imu(1.0 + at, (0.0, 0.0, 0.01), (0.0, 0.0, GRAVITY)), at)
        hear(sensors, Joints(1.0 + at, ALL.names, (*bent.tolist(), *PSI.tolist())), at)
    found, _ = sensors.measurement(4.0, PSI)
    assert found is not None
    assert found.imu is not None
    np.testing.assert_allclose(found.imu.angular_velocity, [0.0, 0.0, 0.01])
    np.testing.assert_allclose(found.imu.specific_force, still)
    np.testing.assert_allclose(found.angular_velocity, [0.0, 0.0, 0.01 - 0.2], atol=1e-6)
    assert found.capture_age == pytest.approx(4.0 - 0.02 * 199)


def test_frames_lead_from_the_world_to_the_centre_of_gravity() -> None:
    robot = in_hover()
    body = Bodies(ROBOT, LINK).of(robot.plant.truth())
    fields = transforms(TickView(3.0, Names(ROBOT, "/other"), body))
    assert fields is not None
    world, root, board = fields["transforms"]
    assert (world["header.frame_id"], world["child_frame_id"]) == ("world", "other/root")
    assert (root["header.frame_id"], root["child_frame_id"]) == ("other/root", "other/cog")
    R = np.asarray(rotation_from_quaternion(np.array(world["transform.rotation"])))
    place = world["transform.translation"] + R @ root["transform.translation"]
    np.testing.assert_allclose(place, body.cog, atol=1e-9)
    assert board["child_frame_id"] == "other/fc"
    np.testing.assert_allclose(
        world["transform.translation"] + R @ board["transform.translation"], body.link, atol=1e-9
    )
    turned = R @ rotation_from_quaternion(np.array(board["transform.rotation"]))
    np.testing.assert_allclose(turned, body.R_W_link, atol=1e-9)
    level = R @ rotation_from_quaternion(np.array(root["transform.rotation"]))
    assert np.arctan2(level[1, 0], level[0, 0]) == pytest.approx(body.yaw, abs=0.01)


@pytest.mark.parametrize("board", ["flight_controller", "fc"])
def test_every_link_hangs_on_one_parent_below_the_world(board: str) -> None:
    """Also of a robot whose own description has a link of the lab's name."""
    robot, names = in_hover(), Names(ROBOT, "/lab")
    measured, link = robot.plant.truth(), names.link
    names.link = lambda name: link(board if name == LINK else name)  # type: ignore[method-assign]
    body = Bodies(ROBOT, LINK).of(measured)
    view = TickView(3.0, names, body, np.concatenate(measured[4:6]))
    moving, fixed = transforms(view), mounts(view)
    assert moving is not None
    assert fixed is not None
    waiting = [*moving["transforms"], *fixed["transforms"]]
    assert len({one["child_frame_id"] for one in waiting}) == len(waiting)
    poses = {"world": (np.zeros(3), np.eye(3))}
    while waiting:
        one = next(one for one in waiting if one["header.frame_id"] in poses)
        waiting.remove(one)
        there, axes = poses[one["header.frame_id"]]
        R = np.asarray(rotation_from_quaternion(np.array(one["transform.rotation"])))
        poses[one["child_frame_id"]] = there + axes @ one["transform.translation"], axes @ R
    for name, place, R in (
        ("lab/cog", body.cog, None),
        ("lab/fc", body.link, body.R_W_link),
        (names.link(LINK), body.link, body.R_W_link),
        (names.link(ROBOT.description.measured_link), body.root, body.R_W_root),
    ):
        np.testing.assert_allclose(poses[name][0], place, atol=1e-9)
        np.testing.assert_allclose(poses[name][1], poses[name][1] if R is None else R, atol=1e-9)
    assert {names.link(one.name) for one in ROBOT.description.links} <= set(poses)


def test_the_full_state_is_that_of_the_centre_of_gravity_and_of_the_labs_link() -> None:
    robot = in_hover()
    body = Bodies(ROBOT, LINK).of(robot.plant.truth())
    fields = full_state(TickView(3.0, Names(ROBOT), body))
    states = {one["id"]: one["state"] for one in fields["states"]}
    assert list(states) == ["x_cog", "y_cog", "z_cog", "x_b", "y_b", "z_b"]
    assert states["z_cog"][1] == (body.cog[2], body.velocity[2], 0.0)
    assert states["x_b"][0] == (body.link[0], body.link_velocity[0], 0.0)
    assert states["x_b"][2] == (0.0, 0.0, 0.0)  # the truth is not known
