"""The tool is a frame of any orientation, and the heading a thing of its own. Pinocchio is the judge."""

import math
from importlib import import_module
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from armed_robots import SIX, TWO, multirotor_with_arm
from skylimb.apps.robot_import.checking import RobotReport, check_robot_file
from skylimb.base.errors import DescriptionError
from skylimb.base.rotations import rotation_from_rpy
from skylimb.control.missions.posture import posture_plan
from skylimb.control.planning.posture import posture_family
from skylimb.control.planning.posture_path import PostureConfig
from skylimb.control.planning.tip_pose import TipTarget, find_posture, tip_position
from skylimb.robots.flight_check import check_robot
from skylimb.robots.model import Robot
from skylimb.simulation.scene import scene_spec
from skylimb.simulation.surfaces import Board

# Pinocchio fills its module at run time, where a type checker cannot look.
pin: Any = import_module("pinocchio")

STILL = np.zeros(0)
Z_OUT = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
"""Columns: z, y and minus x of the frame whose z axis points out of the tool."""


def checked(folder: Path, mapping: str = "", **arm: Any) -> RobotReport:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "mapping.toml").write_text(mapping)
    path = multirotor_with_arm(folder / "made.urdf", **arm)
    return check_robot_file(path, mapping=folder / "mapping.toml")


def tip(position=(0.0, 0.0, 0.0), **more: Any) -> str:
    """A [tip] on the link called tool0."""
    said = {"link": "tool0", "position": list(position), "radius": 0.01, **more}
    return "[tip]\n" + "".join(f"{key} = {value!r}\n" for key, value in said.items())


STRAIGHT = """[posture]
offset = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
slope = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
theta_min = -0.1
theta_max = 0.1
theta_nominal = 0.0
"""
"""Of six joints; none is sought."""

BENT = """[posture]
offset = [0.1, 0.5, -1.0, -0.9, 0.8, -0.8]
slope = [0.0, -0.5, 1.0, 0.0, -0.5, 0.0]
theta_min = -0.35
theta_max = 0.35
theta_nominal = 0.0
"""
"""Of six joints, far from where they are singular."""


class Judge:
    """A robot's URDF as Pinocchio reads it: places in the root's frame."""

    def __init__(self, report: RobotReport) -> None:
        self.names = report.description.shape_joints
        self.model = pin.buildModelFromXML(report.urdf.decode(), pin.JointModelFreeFlyer())
        self.data = self.model.createData()

    def link(self, name: str, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Position and orientation of a link's frame."""
        self._set(q)
        place = self.data.oMf[self.model.getFrameId(name)]
        return np.array(place.translation), np.array(place.rotation)

    def cog(self, q: np.ndarray) -> np.ndarray:
        return np.ravel(pin.centerOfMass(self.model, self.data, self._set(q)))

    def _set(self, q: np.ndarray) -> np.ndarray:
        all_ = pin.neutral(self.model)
        for name, angle in zip(self.names, q, strict=True):
            all_[self.model.joints[self.model.getJointId(name)].idx_q] = angle
        pin.framesForwardKinematics(self.model, self.data, all_)
        return all_


@pytest.mark.parametrize("forward", ["x", "z"])
@pytest.mark.parametrize("heading", ["root", "tool"])
def test_the_tool_is_where_pinocchio_puts_its_frame(tmp_path: Path, forward: str, heading: str) -> None:
    rng = np.random.default_rng(5)
    for k in range(2):
        rpy, frame = rng.uniform(-math.pi, math.pi, (2, 3))
        xyz = rng.uniform(-0.1, 0.1, 3)
        said = tip(xyz.tolist(), rpy=rpy.tolist(), forward=forward, heading=heading) + STRAIGHT
        report = checked(tmp_path / str(k), said, joints=SIX, tool=" ".join(map(str, frame)))
        robot, judge = Robot(report.description), Judge(report)
        for q in rng.uniform(-1.5, 1.5, (5, 6)):
            place, R = judge.link("tool0", q)
            tool = R @ rotation_from_rpy(*rpy) @ (Z_OUT if forward == "z" else np.eye(3))
            found, yaw = robot.tool(q, STILL)
            np.testing.assert_allclose(found, np.column_stack([place + R @ xyz, tool]), atol=1e-12)
            expected = 0.0 if heading == "root" else math.atan2(tool[1, 0], tool[0, 0])
            assert math.remainder(yaw - expected, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)
            assert float(robot.at(q, STILL).tip_heading) == pytest.approx(yaw, abs=1e-12)


@pytest.mark.parametrize(("tool", "forward"), [("0 0 0", "x"), ("0 1.5708 0", "z"), ("0.4 -0.3 2.5", "z")])
def test_a_pose_of_the_tool_in_six_dimensions_is_reached(tmp_path: Path, tool: str, forward: str) -> None:
    said = tip((0.02, 0.0, 0.03), forward=forward) + BENT
    report = checked(tmp_path, said, joints=SIX, tool=tool, rotors=6)
    robot, judge = Robot(report.description), Judge(report)
    rng = np.random.default_rng(2)
    for _ in range(3):
        q = robot.nominal_posture() + rng.uniform(-0.3, 0.3, 6)
        goal, R = tip_position(robot, q, STILL), robot.tool(q, STILL)[0][:, 1:]
        found = find_posture(robot, TipTarget(goal, orientation=R), near=robot.nominal_posture())
        at, turned = judge.link("tool0", found)
        axes = turned @ (Z_OUT if forward == "z" else np.eye(3))
        np.testing.assert_allclose(axes, R, atol=1e-5)
        np.testing.assert_allclose(at + turned @ [0.02, 0.0, 0.03] - judge.cog(found), goal, atol=1e-5)


def test_the_elevation_is_that_of_the_tool_however_its_links_axes_point(tmp_path: Path) -> None:
    report = checked(tmp_path, tip() + BENT, joints=SIX, tool="0 1.5708 0", rotors=6)
    robot, judge = Robot(report.description), Judge(report)
    goal = tip_position(robot, robot.nominal_posture(), STILL)
    q = find_posture(robot, TipTarget(goal, elevation=0.25))
    _, R = judge.link("tool0", q)
    assert math.asin(R[2, 2]) == pytest.approx(0.25, abs=1e-5)


POSTURE = """[posture]
offset = [-1.0, {elbow}]
slope = [0.3, 1.0]
theta_min = -0.3
theta_max = 0.3
theta_nominal = 0.0
"""


@pytest.mark.parametrize("elbow", [2.2, 2.57, 2.9])
def test_an_elbow_past_a_right_angle_leaves_heading_and_reach_alone(tmp_path: Path, elbow: float) -> None:
    """Links go up, over the top, and down: the tool passes through straight down on the way."""
    report = checked(tmp_path, tip((0.1, 0.0, 0.0)) + POSTURE.format(elbow=elbow), limit=3.4)
    assert report.description.tip.heading == "root"
    assert report.can_hover, report.reasons
    robot, judge = Robot(report.description), Judge(report)
    family = posture_family(robot)
    for theta in np.linspace(family.theta_min, family.theta_max, 13):
        q = family.joint_angles(theta)
        place, R = judge.link("tool0", q)
        assert robot.tool(q, STILL)[1] == 0.0
        expected = (place + R @ [0.1, 0.0, 0.0] - judge.cog(q))[0]
        assert family.reach(theta) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("elbow", [2.2, 2.57])
def test_a_heading_by_a_tool_that_turns_past_upright_is_refused_with_its_reason(
    tmp_path: Path, elbow: float
) -> None:
    said = tip((0.1, 0.0, 0.0), heading="tool") + POSTURE.format(elbow=elbow)
    robot = Robot(checked(tmp_path, said, limit=3.4).description)
    with pytest.raises(DescriptionError, match=r"points down in the .*say tip.heading = 'root'"):
        check_robot(robot)


def test_a_flight_through_postures_past_upright_is_refused_too(tmp_path: Path) -> None:
    way = PostureConfig(waypoints=((0.5, -0.5), (0.8, 1.2)))
    for heading in ("root", "tool"):
        said = tip((0.1, 0.0, 0.0), heading=heading)
        robot = Robot(checked(tmp_path / heading, said).description)
        if heading == "root":
            plan = posture_plan(way, robot)
            assert np.all(plan.tip_heading(np.linspace(0.0, plan.duration, 50)) == 0.0)
        else:
            with pytest.raises(DescriptionError, match=r"points down on the way through posture.waypoints"):
                posture_plan(way, robot)


def test_a_foot_lies_across_the_tool_however_its_links_axes_point(tmp_path: Path) -> None:
    """The same robot with another frame drawn at its end: the engine has every ball at the same place."""
    places = []
    for name, tool, rpy in (
        ("x", "0 0 0", None),
        ("z", f"0 {math.pi / 2} 0", None),
        ("y", f"0 0 {-math.pi / 2}", [0.0, 0.0, math.pi / 2]),
    ):
        said = {} if rpy is None else {"mapping": tip(rpy=rpy)}
        description = checked(tmp_path / name, tool=tool, **said).description
        model = scene_spec(description, Board(), 1e-3, 5, foot=0.05)[0].compile()
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        balls = np.array([data.geom(geom).xpos for geom in ("tip", *(f"tip_{k}" for k in range(4)))])
        places.append([*balls, data.geom("tip_plate").xpos])
        assert np.ptp(balls[:, 0]) == pytest.approx(0.0, abs=1e-9)  # the arm is straight ahead at zero
        assert data.geom("tip_plate").xpos[0] < balls[0, 0]
    np.testing.assert_allclose(places[1], places[0], atol=1e-9)
    np.testing.assert_allclose(places[2], places[0], atol=1e-9)


@pytest.mark.parametrize("joints", [TWO, pytest.param(SIX, marks=pytest.mark.slow)])
def test_an_arm_stands_with_its_tool_level_also_where_it_is_bent(tmp_path: Path, joints: Any) -> None:
    """A tool across its last link, z out: what is level is the tool."""
    bent = checked(tmp_path, tip((0.0, 0.0, 0.1), forward="z"), joints=joints, tool="0.0 2.5 0", limit=2.2)
    assert bent.can_touch, bent.reasons
    assert bent.actuation is not None
    assert bent.actuation.ahead
    _, R = Judge(bent).link("tool0", bent.description.posture.nominal)
    assert abs(math.asin(R[2, 2])) < 0.4
    assert R[0, 2] > 0.9
