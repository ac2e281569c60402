"""How hard a robot at rest can push, against what its thrusts, worked out by hand, allow."""

import itertools

import numpy as np
import pytest
from scipy.optimize import linprog

from skylimb.planning.feasible_wrench import FeasibleWrench, feasible_wrench, push_limit
from skylimb.planning.posture import posture_family
from skylimb.planning.press import can_push, greatest_push
from skylimb.planning.vectoring import vectoring_table
from skylimb.robots.description import GRAVITY
from skylimb.robots.loader import load_robot
from skylimb.robots.model import Robot
from skylimb.spatial import rot_x, rot_y, rot_z

X, UP = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("hydrus_xi_quad")


def posture(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    theta = posture_family(robot).theta_nominal
    return posture_family(robot).joint_angles(theta), vectoring_table(robot, "torque").angles(theta)


def needed(robot: Robot, push: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Roll and pitch, and the thrusts, that hold a push with the angles as they are: a fixed-point search."""
    state = robot.at(*posture(robot))
    Q, tilt = state.allocation_C, np.zeros(2)
    thrusts, off = state.hover_thrusts, np.ones(2)
    for _ in range(500):
        R = rot_z(-state.tip_heading) @ rot_y(tilt[1]) @ rot_x(tilt[0])
        wanted = R.T @ (robot.mass * GRAVITY * UP + push)
        torque = np.cross(state.tip_C, R.T @ push)
        thrusts = np.linalg.solve(Q[2:], np.array([wanted[2], *torque]))
        off = wanted[:2] - Q[:2] @ thrusts
        tilt = tilt + 0.3 * np.array([-off[1], off[0]]) / (robot.mass * GRAVITY)
    assert np.abs(off).max() < 1e-6
    return tilt, thrusts


@pytest.mark.parametrize("push", [3.0 * X, 8.0 * X, -6.0 * X, 5.0 * UP])
def test_it_rests_where_a_search_by_hand_finds_tilt_and_thrusts_within_limits(
    robot: Robot, push: np.ndarray
) -> None:
    tilt, thrusts = needed(robot, push)
    assert thrusts.min() > 1.0
    assert thrusts.max() < 30.0
    most = float(np.abs(tilt).max())
    assert can_push(robot, *posture(robot), push, most + 0.01)
    assert not can_push(robot, *posture(robot), push, most - 0.01)


def test_a_thrust_limit_ends_the_push(robot: Robot) -> None:
    most = greatest_push(robot, *posture(robot), X, 100.0, 1.0)
    for push, inside in ((most - 0.1, True), (most + 0.1, False)):
        thrusts = needed(robot, push * X)[1]
        assert bool(thrusts.min() > 1.0 and thrusts.max() < 30.0) is inside
    assert greatest_push(robot, *posture(robot), X, 5.0, 1.0) == pytest.approx(5.0, abs=0.1)


def test_angles_that_move_can_do_no_less(robot: Robot) -> None:
    for tilt in (0.1, 0.3):
        fixed = greatest_push(robot, *posture(robot), X, 30.0, tilt)
        assert greatest_push(robot, *posture(robot), X, 30.0, tilt, 0.3) > fixed


def test_a_body_held_upright_may_still_move_its_vectoring_angles():
    robot = load_robot("tiltable_hexarotor")
    sideways = np.array([0.0, 1.0, 0.0])
    still = push_limit(robot, sideways, tilt=0.0)
    moving = push_limit(robot, sideways, tilt=0.0, moves=0.5)
    assert still < 0.5 < 5.0 < moving


def test_a_fully_actuated_robot_rests_under_a_small_push_to_any_side() -> None:
    """Thrusts at a level attitude show by themselves that it can; a local search missed a tenth of them."""
    robot = load_robot("tilted_hexarotor")
    q, psi = robot.nominal_posture(), np.zeros(0)
    rng = np.random.default_rng(0)
    for _ in range(30):
        direction = rng.normal(size=3)
        push = rng.uniform(0.5, 3.0) * direction / np.linalg.norm(direction)
        assert can_push(robot, q, psi, push, 1.0)


@pytest.mark.parametrize("name", ["hydrus_xi_hex", "tilted_hexarotor"])
@pytest.mark.parametrize("direction", [(0.0, -1.0, 0.0), (-0.8, 0.6, 0.0), (0.6, 0.0, -0.8)])
def test_it_is_the_best_of_linear_programmes_over_all_leans(name: str, direction: tuple[float, ...]) -> None:
    """At a given lean the greatest push is a linear programme; a search by halves stopped 8 % before it."""
    feasible, along, tilt = feasible_wrench(load_robot(name)), np.array(direction), 0.3
    best, around, at = 0.0, np.zeros(2), np.zeros(2)
    for reach in (tilt, 0.05, 0.01):
        for lean in itertools.product(np.linspace(-reach, reach, 13), repeat=2):
            tried = around + lean
            if np.prod(np.cos(tried)) >= np.cos(tilt) and (push := push_at(feasible, along, tried)) > best:
                best, at = push, tried
        around = at
    assert best - 1e-3 <= feasible.push(along, tilt) <= 1.03 * best  # leans are tried on a grid


def push_at(feasible: FeasibleWrench, along: np.ndarray, lean: np.ndarray) -> float:
    """The greatest push with a given roll and pitch; 0 without any."""
    state, weight = feasible.state, float(feasible.hover[2])
    back = (rot_z(-state.tip_heading) @ rot_y(lean[1]) @ rot_x(lean[0])).T
    pushed = np.concatenate([back @ along, np.cross(state.tip_C, back @ along)])
    found = linprog(
        np.append(np.zeros(len(state.hover_thrusts)), -1.0),
        A_eq=np.column_stack([state.allocation_C, -pushed]),
        b_eq=np.concatenate([back @ (weight * UP), np.zeros(3)]),
        bounds=[*np.stack(feasible.thrust_limits, axis=1), (0.0, None)],
    )
    return float(found.x[-1]) if found.status == 0 else 0.0


@pytest.mark.parametrize("name", ["hydrus_xi_quad", "dragon"])
def test_a_push_of_nothing_is_hover(name: str) -> None:
    feasible = feasible_wrench(load_robot(name))
    given = feasible.robot, feasible.joint_angles, feasible.vectoring_angles
    assert can_push(*given, np.zeros(3), 0.1)
    heavier = np.array([0.0, 0.0, float(sum(feasible.thrust_limits[1]))])
    assert not can_push(*given, heavier, 0.1)
