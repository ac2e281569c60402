"""How hard a robot at rest can push, against what its thrusts, worked out by hand, allow."""

import numpy as np
import pytest

from skylimb.planning.feasible_wrench import push_limit
from skylimb.planning.posture import posture_family
from skylimb.planning.press import can_push, greatest_push
from skylimb.planning.vectoring import vectoring_table
from skylimb.robots.loader import load_robot
from skylimb.robots.model import GRAVITY, Robot
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
