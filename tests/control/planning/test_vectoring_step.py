"""Vectoring angles planned in flight: uphill, level, within limits, never to another branch."""

import itertools

import casadi as ca
import numpy as np
import pytest

from guaranteed_torque import guaranteed_torque
from made_robots import chain, multirotor
from skylimb.base.errors import AllocationError
from skylimb.control.planning import vectoring_step
from skylimb.control.planning.joint_torque import rest_function
from skylimb.control.planning.vectoring import ONLINE, vectoring_table
from skylimb.control.planning.vectoring_merit import lever, merit_function, uphill_function
from skylimb.control.planning.vectoring_step import (
    STEP,
    first_vectoring,
    plan_vectoring,
    plan_when,
    settled_vectoring,
)
from skylimb.robots import Robot, load_robot

WAY = np.array([[1.0, 1.0, -0.5], [1.3, 1.2, 0.6], [0.4, 1.4, 1.2]])
"""Postures of hydrus_xi_quad between which its first branch goes on."""


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("hydrus_xi_quad")


def along(begin: np.ndarray, end: np.ndarray) -> np.ndarray:
    count = int(np.ceil(np.max(np.abs(end - begin)) / 0.02))
    return begin + np.linspace(0.0, 1.0, count)[:, None] * (end - begin)


def test_the_gradient_is_that_of_the_merit(robot: Robot) -> None:
    q, psi, small = WAY[0], np.array([2.5, -0.3, -2.4, 2.0]), 1e-6
    merit, gradient, curvature = (np.array(part) for part in uphill_function(robot)(q, psi))
    assert float(merit[0, 0]) == float(merit_function(robot)(q, psi)[0])
    for i, slope in enumerate(gradient.ravel()):
        moved = psi + small * np.eye(4)[i]
        rise = (float(merit_function(robot)(q, moved)[0]) - float(merit[0, 0])) / small
        assert slope == pytest.approx(rise, rel=1e-3, abs=1e-5)
    assert np.linalg.eigvalsh(curvature).min() > 0.0


def test_the_margin_is_the_guaranteed_torque_where_no_thrust_is_nearer(robot: Robot) -> None:
    plan = first_vectoring(robot)
    rest = rest_function(robot)(robot.nominal_posture(), plan.angles).full().ravel()
    state = robot.at(rest, plan.angles)
    torque = guaranteed_torque(state.allocation_C, 30.0)
    room = lever(robot) * min(np.min(state.hover_thrusts - 1.0), np.min(30.0 - state.hover_thrusts))
    assert plan.margin == pytest.approx(min(torque, room), abs=5e-3)
    assert plan.tilt == pytest.approx(np.arccos(state.R_root_C[2, 2]), abs=1e-3)
    assert plan.feasible(3.0)
    assert not plan.feasible(30.0)


def test_on_a_long_way_it_stays_level_and_moves_in_small_steps(robot: Robot) -> None:
    plan = settled_vectoring(robot, WAY[0], first_vectoring(robot).angles)
    for begin, end in itertools.pairwise(WAY):
        for q in along(begin, end):
            last, plan = plan, plan_vectoring(robot, q, plan.angles)
            assert np.max(np.abs(plan.angles - last.angles)) <= STEP + 1e-12
            assert plan.margin > 1.0
            # Where the servos hold the joints with the new angles; it was planned for the angles of before.
            assert plan.tilt < 0.0105
    # The last posture alone says the same: it has followed the best angles nearby.
    settled = settled_vectoring(robot, WAY[-1], plan.angles)
    assert plan.margin > settled.margin - 0.1


def test_the_merit_never_falls_and_the_step_is_kept(robot: Robot) -> None:
    rng = np.random.default_rng(5)
    merit = merit_function(robot)
    for q, psi in zip(rng.uniform(-1.5, 1.5, (40, 3)), rng.uniform(-3.0, 3.0, (40, 4)), strict=True):
        plan = plan_vectoring(robot, q, psi, 0.05)
        assert np.max(np.abs(plan.angles - psi)) <= 0.05 + 1e-12
        rest = rest_function(robot)(q, psi)
        assert float(merit(rest, plan.angles)[0]) >= float(merit(rest, psi)[0])


def test_a_posture_without_torque_is_told(robot: Robot) -> None:
    """All links in a line: no torque about it."""
    first = first_vectoring(robot)
    assert first.margin > 3.0
    straight = settled_vectoring(robot, np.zeros(3), first.angles)
    assert not straight.feasible(2.0)


def test_joint_limits_are_kept(tmp_path) -> None:
    robot = load_robot(chain(tmp_path, bends=("0 0 1",), turns=("1 0 0",), turn_limit=0.25))
    plan = first_vectoring(robot)
    for q in np.linspace(1.0, 1.4, 30)[:, None] * np.ones(3):
        plan = plan_vectoring(robot, q, plan.angles)
        assert np.max(np.abs(plan.angles)) <= 0.25 + 1e-12


def test_a_robot_without_vectoring_has_nothing_to_plan(tmp_path) -> None:
    robot = load_robot(multirotor(tmp_path))
    plan = plan_vectoring(robot, [], [])
    assert plan.angles.shape == (0,)
    assert plan.margin > 0.0


def test_too_heavy_to_hover_is_an_error_that_names_the_posture(robot: Robot, monkeypatch) -> None:
    monkeypatch.setattr(vectoring_step, "find_hovers", lambda *given, **more: [])
    with pytest.raises(AllocationError, match=r"hydrus_xi_quad.*\[1\.5, 1\.5, 1\.5\]"):
        first_vectoring(robot, [1.5, 1.5, 1.5])


def test_a_plan_comes_when_it_is_due_on_numbers_and_on_symbols(robot: Robot) -> None:
    psi = first_vectoring(robot).angles
    kept, margin = plan_when(robot, False, WAY[1], psi, 0.1, 7.0)
    assert np.array_equal(kept, psi)
    assert margin == 7.0
    planned, margin = plan_when(robot, True, WAY[1], psi, 0.1, 7.0)
    assert np.array_equal(planned, plan_vectoring(robot, WAY[1], psi, 0.1).angles)
    due, q = ca.SX.sym("due"), ca.SX.sym("q", 3)
    traced = ca.Function("traced", [due, q], list(plan_when(robot, due, q, ca.DM(psi), 0.1, 7.0)))
    assert np.array_equal(traced(1.0, WAY[1])[0].full().ravel(), planned)
    assert float(traced(1.0, WAY[1])[1]) == margin
    assert np.array_equal(traced(0.0, WAY[1])[0].full().ravel(), psi)


def test_the_table_of_angles_that_are_planned_is_those_of_the_nominal_posture(robot: Robot) -> None:
    table = vectoring_table(robot, ONLINE)
    assert np.allclose(table.angles(np.array([0.3, 0.6])), first_vectoring(robot).angles)
    assert np.all(table.slope(0.5) == 0.0)
