"""Messages of ROS 2: types that are known, bytes that come back, frames that are the robot's own."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from skylimb.analysis.exchange import lab_topics as topics
from skylimb.analysis.exchange.body import Bodies
from skylimb.analysis.exchange.frames import lab_link
from skylimb.analysis.exchange.lab_ticks import TickView
from skylimb.analysis.exchange.lab_topics import Topic, require_namespace
from skylimb.analysis.exchange.messages import Desire, FourAxes, Imu, Nav, Pwms
from skylimb.analysis.exchange.ros2_topics import VIEWS, OwnNames, spoken
from skylimb.analysis.exchange.ros2_types import Ros2Types
from skylimb.base.errors import ConfigError
from skylimb.base.rotations import rotation_from_quaternion
from skylimb.base.signal_table import PLACE_TERMS, TURN_TERMS
from skylimb.robots.loader import load_robot

ROBOT = load_robot("hydrus_xi_quad")
TYPES = Ros2Types()


def view(seed: int = 0) -> TickView:
    rng = np.random.default_rng(seed)
    joints, gimbals = rng.uniform(-1.0, 1.0, ROBOT.n_joints), rng.uniform(-1.0, 1.0, ROBOT.n_vectoring)
    turn = rng.normal(size=4)
    measured = (rng.normal(size=3), turn / np.linalg.norm(turn), *rng.normal(size=(2, 3)), joints, gimbals)
    body, angles = Bodies(ROBOT, lab_link(ROBOT)).of(measured), np.concatenate([joints, gimbals])
    command, felt = (np.ones(ROBOT.n_rotors), joints, gimbals), (rng.normal(size=3), rng.normal(size=3))
    still, names = np.zeros(3), OwnNames(ROBOT)
    return TickView(
        1.5, names, body, angles, command, felt=felt, state=5, arming=0, target=(still, still, 0.0)
    )


def made(name: str, tick: TickView) -> Any:
    """The message of a topic, as it comes out of its bytes."""
    every = [spoken(topic) for topic in vars(topics).values() if isinstance(topic, Topic)]
    topic = next(one for one in (*every, *VIEWS) if one is not None and one.name == name)
    assert topic.make is not None
    return TYPES.types.deserialize_cdr(TYPES.write(topic.type, topic.make(tick), 0), topic.type)


def pose(transform: Any) -> tuple[np.ndarray, np.ndarray]:
    place, turn = transform.transform.translation, transform.transform.rotation
    R = rotation_from_quaternion(np.array([turn.w, turn.x, turn.y, turn.z]))
    return np.array([place.x, place.y, place.z]), np.asarray(R)


@pytest.mark.parametrize("seed", range(3))
def test_all_links_hang_together_as_the_robot_does(seed: int) -> None:
    tick = view(seed)
    assert tick.body is not None
    assert tick.angles is not None
    moving, fixed = made("/tf", tick).transforms, made("/tf_static", tick).transforms
    poses = {"world": (np.zeros(3), np.eye(3))}
    waiting = {one.child_frame_id: one for one in (*moving, *fixed)}
    assert len(waiting) == len(moving) + len(fixed)  # no frame has two parents
    while waiting:
        child = next(name for name, one in waiting.items() if one.header.frame_id in poses)
        one = waiting.pop(child)
        (there, axes), (place, R) = poses[one.header.frame_id], pose(one)
        poses[child] = there + axes @ place, axes @ R
    q, psi = np.split(tick.angles, [ROBOT.n_joints])
    base = ROBOT.link_pose_function(ROBOT.description.measured_link)(q, psi).full()
    for link in ROBOT.description.links:
        found = ROBOT.link_pose_function(link.name)(q, psi).full()
        turn = tick.body.R_W_root @ base[:, 1:].T
        np.testing.assert_allclose(
            poses[link.name][0], tick.body.root + turn @ (found[:, 0] - base[:, 0]), atol=1e-9
        )
        np.testing.assert_allclose(poses[link.name][1], turn @ found[:, 1:], atol=1e-9)
    np.testing.assert_allclose(poses["cog"][0], tick.body.cog, atol=1e-9)
    assert topics.TF_STATIC.latched


def test_the_velocity_of_an_odometry_is_in_its_childs_axes() -> None:
    tick = view()
    assert tick.body is not None
    odom = made("uav/baselink/odom", tick)
    linear = odom.twist.twist.linear
    np.testing.assert_allclose(
        tick.body.R_W_link @ [linear.x, linear.y, linear.z], tick.body.link_velocity, atol=1e-9
    )
    assert (odom.header.frame_id, odom.child_frame_id) == ("world", "flight_controller")


@pytest.mark.parametrize(
    ("topic", "value"),
    [
        (topics.FOUR_AXES, FourAxes((0.0, 0.1, 0.2), (1.0, 2.0))),
        (topics.PWMS, Pwms(2.5, (1000, 1100))),
        (topics.DESIRE, Desire(0.1, 0.2, 0.3)),
        (topics.CONFIG, 2),
        (topics.ACK, 1),
        (topics.BATTERY, 24.5),
        (topics.ORDERS[0], None),
    ],
)
def test_plain_values_come_back(topic: Topic, value: Any) -> None:
    on_ros2 = spoken(topic)
    assert on_ros2 is not None
    assert TYPES.read(on_ros2.type, TYPES.write(on_ros2.type, value, 7)) == value


def test_what_the_laws_add_up_is_told_along_every_axis() -> None:
    told = {name: np.array([1.0, 2.0, 3.0]) * place for place, name in enumerate(PLACE_TERMS, 1)}
    told |= {name: np.array([0.5, -0.5, 4.0]) * place for place, name in enumerate(TURN_TERMS, 1)}
    tick = replace(view(), signals=told)
    terms = made("debug/pose/pid", tick)
    assert [[*one] for one in (terms.y.p_term, terms.y.i_term, terms.y.d_term)] == [[2.0], [4.0], [6.0]]
    assert [[*one] for one in (terms.yaw.p_term, terms.yaw.d_term, terms.yaw.total)] == [
        [4.0],
        [12.0],
        [24.0],
    ]
    assert tick.body is not None
    assert terms.z.err_p == pytest.approx(-tick.body.cog[2])
    # Roll and pitch are about the axes of the lab's link, which has another yaw than C.
    roll, pitch = terms.roll.p_term[0], terms.pitch.p_term[0]
    assert np.hypot(roll, pitch) == pytest.approx(np.hypot(0.5, 0.5), rel=1e-6)
    assert not len(made("debug/pose/pid", view()).x.p_term)


def test_an_imu_comes_back_in_the_plain_order() -> None:
    tick, topic = view(), spoken(topics.IMU)
    assert topic is not None
    assert topic.make is not None
    felt = TYPES.read(topic.type, TYPES.write(topic.type, topic.make(tick), 0))
    assert isinstance(felt, Imu)
    assert tick.felt is not None
    assert tick.body is not None
    np.testing.assert_allclose([felt.gyro, felt.acceleration], tick.felt)
    x, y, z, w = felt.quaternion_xyzw
    np.testing.assert_allclose(
        rotation_from_quaternion(np.array([w, x, y, z])), tick.body.R_W_link, atol=1e-9
    )


@pytest.mark.parametrize(("frame", "own"), [("world", 0), ("", 1), ("link1", 1)])
def test_a_twist_steers_in_the_axes_that_it_names(frame: str, own: int) -> None:
    fields = {"header.frame_id": frame, "twist.linear": (0.1, 0.2, 0.3), "twist.angular": (0.0, 0.0, 0.4)}
    kind = "geometry_msgs/msg/TwistStamped"
    nav = TYPES.read(kind, TYPES.write(kind, fields, 0))
    assert nav == Nav(1, 1, 1, (0.0, 0.0, 0.0), (0.1, 0.2, 0.3), yaw_rate=0.4, frame=own)


def test_whatever_has_no_type_on_ros_2_is_not_spoken() -> None:
    assert spoken(topics.RPY_PID) is None
    assert spoken(topics.TARGET_POSE) is topics.TARGET_POSE
    named = [topic for topic in vars(topics).values() if isinstance(topic, Topic)]
    kinds = {one.type for topic in named if (one := spoken(topic)) is not None}
    messages = {kind for kind in kinds if "/srv/" not in kind}  # services are a ROS 2's own
    assert all(TYPES.knows(kind) for kind in messages)


def test_a_root_that_is_not_the_measured_link_is_found() -> None:
    tick = view()
    names: Any = OwnNames(ROBOT)
    names._description = replace(ROBOT.description, measured_link="link3")
    there = ROBOT.link_pose_function("link3")(*np.split(np.asarray(tick.angles), [ROBOT.n_joints])).full()
    link, (place, R), _ = names.placed(tick.angles, (there[:, 0], there[:, 1:]))
    assert link == ROBOT.description.root
    np.testing.assert_allclose(place, 0.0, atol=1e-9)
    np.testing.assert_allclose(R, np.eye(3), atol=1e-9)


def test_markers_show_the_target_and_the_force() -> None:
    tick = replace(view(), signals={"external_force_estimate": np.array([0.0, 0.0, 2.0])})
    assert tick.body is not None
    ball, arrow = made("markers", tick).markers
    assert (ball.type, arrow.type) == (ball.SPHERE, arrow.ARROW)
    tail, head = ([point.x, point.y, point.z] for point in arrow.points)
    np.testing.assert_allclose(tail, tick.body.cog)
    np.testing.assert_allclose(np.subtract(head, tail), [0.0, 0.0, 0.1], atol=1e-12)


@pytest.mark.parametrize("namespace", ["", "/", "/a//b", "a b", "1a", "a/", "a/b", "/hydrus_xi"])
def test_a_namespace_is_one_of_ros(namespace: str) -> None:
    if namespace in ("a/", "a/b", "/hydrus_xi"):
        require_namespace(namespace)
        return
    with pytest.raises(ConfigError, match="no namespace of ROS"):
        require_namespace(namespace)
