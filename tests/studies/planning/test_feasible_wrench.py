"""What a robot can do in a posture, against linear programmes over its thrusts."""

import math

import numpy as np
import pytest
from scipy.optimize import linprog

import skylimb
from made_robots import multirotor
from skylimb.base.errors import ConfigError, UnreachableError
from skylimb.base.rotations import rot_z
from skylimb.robots import load_robot
from skylimb.robots.equilibrium import can_hold
from skylimb.robots.equilibrium_results import LEVEL, Within
from skylimb.studies.planning.feasible_wrench import (
    FeasibleWrench,
    feasible_wrench,
    push_limit,
    unit_vector,
)
from skylimb.studies.planning.wrench_figure import wrench_figure
from skylimb.studies.planning.wrench_tables import as_tables, summary


@pytest.fixture(scope="module")
def quad() -> FeasibleWrench:
    return feasible_wrench(skylimb.load_robot("hydrus_xi_quad"))


@pytest.fixture(scope="module")
def canted(tmp_path_factory: pytest.TempPathFactory) -> FeasibleWrench:
    """Six rotors canted to both sides, which give wrenches in all six directions, and a stick."""
    return feasible_wrench(load_robot(multirotor(tmp_path_factory.mktemp("canted"))))


@pytest.fixture(params=["quad", "canted"])
def feasible(request: pytest.FixtureRequest) -> FeasibleWrench:
    return request.getfixturevalue(request.param)


def most(
    feasible: FeasibleWrench, rows: np.ndarray, start: np.ndarray, way: np.ndarray, low: float | None = None
) -> float:
    """The greatest t for which thrusts within the limits (from `low` on, if given) make start + t way."""
    lower, upper = feasible.robot.thrust_limits()
    lower = lower if low is None else np.full_like(lower, low)
    n = len(upper)
    found = linprog(
        [*np.zeros(n), -1.0],
        A_eq=np.column_stack([rows, -way]),
        b_eq=start,
        bounds=[*zip(lower, upper, strict=True), (None, None)],
        method="highs",
    )
    return float(found.x[n]) if found.status == 0 else float("nan")


def directions(count: int = 200) -> np.ndarray:
    ways = np.random.default_rng(0).normal(size=(count, 3))
    return ways / np.linalg.norm(ways, axis=1)[:, None]


def test_fct_min_is_that_of_the_linear_programme(feasible: FeasibleWrench) -> None:
    Q_r, zero = feasible.state.allocation_C[3:], np.zeros(3)
    for way in directions(60):
        assert most(feasible, Q_r, zero, way, 0.0) >= feasible.fct_min - 1e-9
    found = [most(feasible, Q_r, zero, way, 0.0) for way in nearest_normals(feasible, Q_r)]
    assert min(found) == pytest.approx(feasible.fct_min, abs=1e-9)


def nearest_normals(feasible: FeasibleWrench, rows: np.ndarray) -> list[np.ndarray]:
    """Normals of all faces of a set of three rows."""
    n = rows.shape[1]
    crosses = [np.cross(rows[:, i], rows[:, j]) for i in range(n) for j in range(n) if i != j]
    return [way / np.linalg.norm(way) for way in crosses if np.linalg.norm(way) > 1e-9]


def test_fcf_min_is_that_of_the_linear_programme(feasible: FeasibleWrench) -> None:
    Q_t, weight = feasible.state.allocation_C[:3], feasible.hover[:3]
    found = [most(feasible, Q_t, weight, way, 0.0) for way in nearest_normals(feasible, Q_t)]
    assert min(found) == pytest.approx(feasible.fcf_min, abs=1e-9)


def test_torques_in_hover_keep_the_lift(feasible: FeasibleWrench) -> None:
    torques, Q = feasible.hover_torques, feasible.state.allocation_C[2:]
    assert torques is not None
    assert torques.dimension == 3
    least = torques.margin(np.zeros(3))
    found = []
    for way in directions(100):
        reach = most(feasible, Q, feasible.hover[2:], np.array([0.0, *way]))
        assert torques.reach(np.zeros(3), way) == pytest.approx(reach, abs=1e-8)
        found.append(reach)
    assert 0.0 < least <= min(found)
    assert least == pytest.approx(min(found), rel=0.25)
    assert least < feasible.fct_min


def test_level_forces_and_pushes_are_those_of_linear_programmes(canted: FeasibleWrench) -> None:
    Q, state = canted.state.allocation_C, canted.state
    forces, pushes = canted.level_forces, canted.level_pushes
    assert forces is not None
    assert pushes is not None
    for way in directions(60):
        assert forces.reach(np.zeros(3), way) == pytest.approx(
            most(canted, Q, canted.hover, np.array([*way, 0, 0, 0])), abs=1e-8
        )
        p = rot_z(state.tip_heading) @ way
        pushed = most(canted, Q, canted.hover, np.array([*p, *np.cross(state.tip_C, p)]))
        assert pushes.reach(np.zeros(3), way) == pytest.approx(pushed, abs=1e-8)
        level = canted.push(3.0 * way, Within(0.0))  # level is less than a thousandth of a radian
        assert level
        assert 0.0 <= level.force - pushed < 3.0 * LEVEL * canted.hover[2]
        assert canted.times(np.array([*p, *np.cross(state.tip_C, p)])) == pytest.approx(pushed, abs=1e-8)


def test_a_margin_is_negative_for_what_cannot_be_given(canted: FeasibleWrench, quad: FeasibleWrench) -> None:
    way = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    far = canted.times(way)
    assert canted.margin(0.0 * way) > canted.margin(0.5 * far * way) > 0.0
    assert canted.margin(far * way) == pytest.approx(0.0, abs=1e-9)
    assert canted.margin(1.1 * far * way) < 0.0
    lift = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    assert quad.margin(0.0 * way) == 0.0  # a little side force is beyond a robot of four rotors
    assert -1.0 <= quad.margin(way) < -0.5
    assert quad.times(way) == 0.0
    weight = quad.hover[2]
    assert quad.times(lift) == pytest.approx(weight * (30.0 / quad.state.hover_thrusts.max() - 1.0), rel=1e-9)


def test_a_robot_of_four_rotors_pushes_to_the_side_by_tilting(quad: FeasibleWrench) -> None:
    forward = np.array([2.0, 0.0, 0.0])
    level, found = push_limit(quad.robot, forward, tilt=0.0), push_limit(quad.robot, -forward, tilt=0.2)
    assert not level
    assert str(level) == "the tilt (0.001 rad) is in the way"
    assert found
    given = quad.robot, quad.joint_angles, quad.vectoring_angles
    can = [
        bool(can_hold(*given, np.array([-force, 0.0, 0.0]), Within(0.2)))
        for force in (found.force - 1e-3, found.force + 0.1)
    ]
    assert can == [True, False]
    assert found.force == pytest.approx(quad.hover[2] * np.tan(0.2), rel=0.3)


def test_another_posture_gets_the_vectoring_angles_of_the_way_there(quad: FeasibleWrench) -> None:
    robot, q = quad.robot, quad.joint_angles + np.array([0.05, -0.1, 0.05])
    there = feasible_wrench(robot, q)
    np.testing.assert_array_equal(there.joint_angles, q)
    assert 0.0 < np.abs(there.vectoring_angles - quad.vectoring_angles).max() < 0.5
    assert np.abs(there.state.R_root_C[:2, 2]).max() <= 0.0101
    given = feasible_wrench(robot, q, quad.vectoring_angles)
    np.testing.assert_array_equal(given.vectoring_angles, quad.vectoring_angles)
    assert given.fct_min < there.fct_min + 0.05


def test_bad_angles_and_directions_are_refused_in_a_line(quad: FeasibleWrench) -> None:
    with pytest.raises(UnreachableError, match="limits"):
        feasible_wrench(quad.robot, np.array([3.0, 0.0, 0.0]))
    with pytest.raises(ConfigError, match="joint_angles"):
        feasible_wrench(quad.robot, np.array([0.1, 0.1]))
    with pytest.raises(ConfigError, match="vectoring_angles"):
        feasible_wrench(quad.robot, None, np.zeros(3))
    for wrong in ([0.0, 0.0, 0.0], [1.0, 0.0], [np.nan, 0.0, 1.0]):
        with pytest.raises(ConfigError, match="direction"):
            unit_vector(np.array(wrong))


def test_numbers_in_words_and_as_tables(feasible: FeasibleWrench) -> None:
    lines, tables = summary(feasible), as_tables(feasible)
    assert lines["FCTmin, N m"].startswith(f"{feasible.fct_min:.2f} ")
    rank = feasible.wrenches.dimension
    assert tables["wrenches"]["dimension"] == rank
    assert ("all six" in lines["rotors give, angles held"]) == (rank == 6)
    corners = np.array(tables["wrenches"]["vertices"]) @ np.array(tables["wrenches"]["axes"])
    highest = (np.array(tables["wrenches"]["normals"]) @ corners.T).max(axis=1)
    np.testing.assert_allclose(highest, tables["wrenches"]["offsets"], atol=1e-9)
    assert tables["hover_torques"]["volume"] == pytest.approx(feasible.hover_torques.volume)  # type: ignore[union-attr]


def test_the_picture_shows_the_solid_sets(feasible: FeasibleWrench) -> None:
    push = np.array([1.0, 0.0, 0.0])
    figure = wrench_figure(feasible, {"+x": (push, 5.0), "-x": (-push, math.nan)})
    left, bars, right = figure.axes
    assert len(right.collections) == 2  # the torques and the ball in them
    solid = feasible.wrenches.dimension == 6
    assert sum("Poly3D" in type(one).__name__ for one in left.collections) == solid
    least = feasible.hover_torques.margin(np.zeros(3))  # type: ignore[union-attr]
    assert any(f"{max(least, 0.0):.2f} about every axis" in text.get_text() for text in figure.texts)
    assert [label.get_text() for label in bars.get_yticklabels()] == ["+x", "-x"]
    assert [text.get_text() for text in bars.texts] == ["5.0", "none found"]
