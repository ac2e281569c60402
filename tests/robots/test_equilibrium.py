"""What can be held, against linear programmes (HiGHS), Pinocchio's torques and searches by hand."""

import math
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from made_robots import chain, multirotor
from push_programmes import Pushes, best_over_leans, lean_of, limits, push_at
from skylimb.base.rotations import rot_x, rot_y, rot_z
from skylimb.control.planning.posture import posture_family
from skylimb.control.planning.vectoring import vectoring_table
from skylimb.robots.equilibrium import can_hold, greatest_push
from skylimb.robots.equilibrium_results import LEVEL, TILT, Held, NotHeld, Within
from skylimb.robots.loader import list_robots, load_robot, read_description
from skylimb.robots.model import Robot

# Pinocchio fills its module at run time, where a type checker cannot look.
pin: Any = import_module("pinocchio")

X = np.array([1.0, 0.0, 0.0])
RIGID = Within(TILT, servo=1e6, stiff=True)
NAMES = [name for name in list_robots() if name != "hydrus_xi_quad_mast"]


def posture(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """Angles of the nominal posture; of one that nobody searched a table for, none."""
    if robot.name == "tiltable_hexarotor":
        return robot.nominal_posture(), robot.description.vectoring_start
    theta = posture_family(robot).theta_nominal
    return posture_family(robot).joint_angles(theta), vectoring_table(robot, "torque").angles(theta)


def directions(count: int, seed: int) -> np.ndarray:
    ways = np.random.default_rng(seed).normal(size=(count, 3))
    return ways / np.linalg.norm(ways, axis=1)[:, None]


@pytest.mark.parametrize("name", NAMES)
def test_with_stiff_joints_it_is_the_best_of_linear_programmes_over_all_leans(name: str) -> None:
    robot = load_robot(name)
    q, psi = posture(robot)
    for along in directions(3, 1):
        found = greatest_push(robot, q, psi, along, RIGID)
        if not found:
            assert best_over_leans(robot, q, psi, along, np.zeros(2)) < 0.0
            continue
        lean = lean_of(robot, found, q, psi)
        assert found.tilt == pytest.approx(np.arccos(np.prod(np.cos(lean))), abs=1e-4)
        best = best_over_leans(robot, q, psi, along, lean)
        assert best - 2e-4 * robot.weight <= found.force <= best + 2e-4 * robot.weight


def pinocchios_torques(robot: Robot, found: Held, joint_angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What is missing for a rest, force and torque (6,), and the torque that each shape joint has to hold."""
    description = robot.description
    model = pin.buildModelFromUrdf(str(description.sources[1].path), pin.JointModelFreeFlyer())
    data, q = model.createData(), pin.neutral(model)
    for names, angles in (
        (description.shape_joints, joint_angles),
        (description.vectoring_joints, found.vectoring_angles),
    ):
        for name, angle in zip(names, angles, strict=True):
            index = model.idx_qs[model.getJointId(name)]
            wide = model.joints[model.getJointId(name)].nq == 2
            q[index : index + 1 + wide] = [math.cos(angle), math.sin(angle)] if wide else [angle]
    heading = robot.at(joint_angles, found.vectoring_angles).tip_heading
    lean = lean_of(robot, found, joint_angles, found.vectoring_angles)
    R = rot_z(-heading) @ rot_y(lean[1]) @ rot_x(lean[0])
    q[3:7] = pin.Quaternion(R).coeffs()
    model.gravity.linear = np.array([0.0, 0.0, -description.gravity])
    pin.framesForwardKinematics(model, data, q)
    torques = pin.computeGeneralizedGravity(model, data, q).copy()
    pushes = [
        (
            rotor.link,
            rotor.xyz,
            thrust * rotor.R[:, 2],
            rotor.drag_torque_coefficient * thrust * rotor.R[:, 2],
        )
        for rotor, thrust in zip(description.rotors, found.thrusts, strict=True)
    ]
    tip = data.oMf[model.getFrameId(description.tip.link, pin.FrameType.BODY)].rotation.T @ -found.push
    pushes.append((description.tip.link, description.tip.position, tip, np.zeros(3)))
    for link, xyz, force, torque in pushes:
        frame = model.getFrameId(link, pin.FrameType.BODY)
        J = pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL)
        torques -= J.T @ np.concatenate([force, torque + np.cross(xyz, force)])
    shape = [model.idx_vs[model.getJointId(name)] for name in description.shape_joints]
    return torques[:6], -torques[shape]


@pytest.mark.parametrize("name", NAMES)
def test_a_rest_is_one_for_pinocchio_and_servos_rest_beside_their_commands(name: str) -> None:
    robot = load_robot(name)
    q, psi = posture(robot)
    for along in directions(3, 2):
        found = greatest_push(robot, q, psi, along)
        assert found or found.limit is not None
        if not found:
            continue
        missing, torques = pinocchios_torques(robot, found, found.joint_angles)
        np.testing.assert_allclose(missing, 0.0, atol=1e-4 * robot.weight)
        np.testing.assert_allclose(found.joint_torques, torques, atol=1e-3)
        servo = robot.description.shape_servos
        np.testing.assert_allclose(servo.stiffness * (found.joint_angles - q), found.joint_torques, atol=1e-4)
        assert np.all(np.abs(found.joint_torques) <= servo.torque_limit + 1e-5)
        assert np.all(found.thrusts >= limits(robot)[:, 0])
        assert np.all(found.thrusts <= limits(robot)[:, 1])
        assert found.tilt <= TILT + 1e-6


@pytest.mark.parametrize("name", ["hydrus_xi_quad", "hydrus_xi_hex", "dragon"])
def test_a_little_less_is_held_and_a_little_more_is_not_for_the_limit_that_is_named(name: str) -> None:
    robot = load_robot(name)
    given = robot, *posture(robot)
    for along in directions(3, 3):
        most = greatest_push(*given, along)
        assert most
        assert can_hold(*given, (most.force - 0.02) * along)
        more = can_hold(*given, (most.force + 0.05) * along)
        assert isinstance(more, NotHeld)
        assert more.greatest == pytest.approx(most.force, abs=1e-3)
        assert more.excess > 0.0
        assert more.limit is not None
        # Whatever is named ends it: the state is at that limit.
        at = {
            "greatest thrust": found_near(most.thrusts, limits(robot)[:, 1]),
            "least thrust": found_near(most.thrusts, limits(robot)[:, 0]),
            "servo": found_near(np.abs(most.joint_torques), robot.description.shape_servos.torque_limit),
            "tilt": abs(most.tilt - TILT) < 1e-3,
        }
        assert most.limit is not None
        assert at[most.limit.kind], most.limit


def found_near(values: np.ndarray, limit: Any) -> bool:
    return bool(np.any(np.abs(values - limit) < 1e-3))


def test_a_servo_ends_a_push_that_thrusts_alone_would_hold() -> None:
    robot = load_robot("hydrus_xi_quad")
    given = robot, *posture(robot)
    held, rigid = greatest_push(*given, X), greatest_push(*given, X, RIGID)
    assert held
    assert rigid
    assert held.force < 0.5 * rigid.force
    assert str(held.limit) == "the servo of 'joint2' (3.3 N m)"
    half = greatest_push(*given, X, Within(servo=0.8))
    assert half
    assert half.force < held.force


def test_a_body_held_upright_may_still_move_its_vectoring_angles() -> None:
    """Level is the measured link: four rotors have no side force with angles held, and some that move."""
    for name in ("hydrus_xi_quad", "tiltable_hexarotor"):
        robot = load_robot(name)
        given = robot, *posture(robot)
        still = greatest_push(*given, X, Within(0.0))
        moving = greatest_push(*given, X, Within(0.0, math.inf))
        assert moving
        assert moving.tilt <= LEVEL + 1e-6
        assert moving.force > 5.0
        assert not still or still.force < 0.5 * moving.force


@pytest.mark.parametrize("name", ["hydrus_xi_quad", "tiltable_hexarotor"])
def test_no_vectoring_angles_drawn_at_random_push_harder(name: str) -> None:
    """At each of them the greatest level push is a linear programme."""
    robot = load_robot(name)
    q, psi = posture(robot)
    found = greatest_push(robot, q, psi, X, Within(0.0, math.inf, servo=1e6, stiff=True))
    assert found
    again = push_at(robot, q, found.vectoring_angles, X, lean_of(robot, found, q, found.vectoring_angles))
    assert again == pytest.approx(found.force, rel=1e-3)
    drawn = np.random.default_rng(4).uniform(-math.pi, math.pi, (300, robot.n_vectoring))
    near = found.vectoring_angles + np.random.default_rng(5).normal(scale=0.1, size=(300, robot.n_vectoring))
    level, asked = np.zeros(2), [Pushes(robot, q, one, X) for one in (*drawn, *near)]
    beyond = [one.at(level) for one in asked if one.at_most(level) > found.force + 1e-3]
    assert max(beyond, default=0.0) <= found.force + 1e-3


def test_angles_that_move_can_do_no_less() -> None:
    robot = load_robot("hydrus_xi_quad")
    given = robot, *posture(robot)
    for tilt in (0.1, 0.3):
        fixed, moving = (greatest_push(*given, X, Within(tilt, moves)) for moves in (0.0, 0.3))
        assert fixed
        assert moving
        assert moving.force > fixed.force
        away = np.abs(moving.vectoring_angles - given[2])
        assert away.max() <= 0.3 + 1e-6


def test_more_freedom_never_pushes_less() -> None:
    """Searches from the given angles alone found 15.3 N with moves of 1.5 rad; 17.8 N can be held."""
    robot = load_robot("hydrus_xi_quad")
    found = [greatest_push(robot, *posture(robot), X, Within(0.35, moves)) for moves in (0.0, 0.5, 1.0, 1.5)]
    forces = [one.force if one else 0.0 for one in found]
    assert forces == sorted(forces)
    assert forces[-1] > 17.0


@pytest.mark.parametrize(
    ("along", "way"),
    [
        pytest.param(X, (1.0, 3.0, math.inf), marks=pytest.mark.slow),
        (np.array([0.0, 1.0, 0.0]), (1.0, math.inf)),
    ],
)
def test_more_moves_never_hold_less(along, way):
    """Of all moves of DRAGON's angles a search ended at 76.3 N along x, of moves by 3 rad at 77.4 N."""
    robot = load_robot("dragon")
    given = robot, robot.nominal_posture(), robot.description.vectoring_start
    found = [greatest_push(*given, along, Within(0.35, moves)) for moves in way]
    forces = [one.force for one in found if isinstance(one, Held)]
    assert len(forces) == len(way)
    assert forces == sorted(forces)


def test_the_margin_is_the_torque_that_is_left_and_what_is_kept_is_left(robot_of_six: Robot) -> None:
    for robot in (load_robot("hydrus_xi_quad"), robot_of_six):
        given = robot, *posture(robot)
        hover = can_hold(*given)
        assert hover
        matrix = robot.wrench_function(hover.joint_angles, hover.vectoring_angles).full()[2:]
        swing = np.linalg.pinv(matrix)[:, 1:]
        low, high = limits(robot).T
        for axis in directions(200, 6):
            changed = hover.thrusts + hover.margin * swing @ axis
            assert np.all(changed >= low - 1e-6)
            assert np.all(changed <= high + 1e-6)
        most = greatest_push(*given, -X, Within(margin=0.7 * hover.margin))
        assert most
        assert most.margin >= 0.7 * hover.margin - 1e-4
        assert not can_hold(*given, None, Within(margin=hover.margin + 0.05))


def test_a_hover_that_least_norm_thrusts_miss_is_found(tmp_path: Path) -> None:
    """Six rotors leave a choice: heavy in front, least-norm thrusts go below the least, others do not."""
    robot = heavy_in_front(tmp_path)
    q, psi = robot.nominal_posture(), np.zeros(0)
    assert robot.at(q, psi).hover_thrusts.min() < limits(robot)[:, 0].min()
    hover = can_hold(robot, q, psi)
    assert hover
    assert hover.thrusts.min() >= limits(robot)[:, 0].min()


def heavy_in_front(folder: Path) -> Robot:
    path = multirotor(folder, cant=0.5, mass=0.7, thrust_max=12.0)
    urdf = path.with_name("robot.urdf")
    front = '<link name="load"><inertial><origin xyz="0 0 0"/><mass value="0.6"/>'
    front += '<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    front += '<joint name="hold" type="fixed"><parent link="base"/><child link="load"/>'
    front += '<origin xyz="0.45 0 0"/></joint></robot>'
    urdf.write_text(urdf.read_text().replace("</robot>", front))
    return Robot(read_description(path))  # as it is described, without thrusts chosen for it


@pytest.fixture
def robot_of_six(tmp_path: Path) -> Robot:
    return load_robot(multirotor(tmp_path / "six"))


@pytest.mark.parametrize("name", ["hydrus_xi_quad", "dragon"])
def test_a_push_of_nothing_is_hover_and_more_than_all_thrusts_is_not_held(name: str) -> None:
    robot = load_robot(name)
    given = robot, *posture(robot)
    assert can_hold(*given, np.zeros(3))
    heavier = np.array([0.0, 0.0, float(limits(robot)[:, 1].sum())])
    found = can_hold(*given, heavier)
    assert isinstance(found, NotHeld)
    assert found.greatest is not None
    assert 0.0 < found.greatest < heavier[2]
    assert str(found).endswith("is in the way")


def test_what_cannot_hover_says_so_and_has_no_greatest_push(tmp_path: Path) -> None:
    robot = load_robot("hydrus_quad")
    found = greatest_push(robot, *posture(robot), X, Within(0.0))
    assert isinstance(found, NotHeld)
    assert found.limit is not None
    assert found.limit.kind == "tilt"
    assert found.greatest is None


def test_few_rotors_hover_without_a_margin(tmp_path: Path) -> None:
    from skylimb.robots.loader import read_description

    robot = Robot(read_description(chain(tmp_path, links=2, turns=("1 0 0", "0 1 0"))))
    found = can_hold(robot, robot.nominal_posture(), np.full(4, 0.1), None, Within(1.0, math.inf))
    assert found
    assert found.margin == 0.0
    assert found.room > 0.1
