"""Guaranteed control torque against geometry, and the vectoring angles along the posture family."""

import logging
from contextlib import suppress
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

from guaranteed_torque import guaranteed_torque, tilt_along, torque_along
from skylimb.base.errors import AllocationError, UnreachableError
from skylimb.control.planning import vectoring_files, vectoring_search
from skylimb.control.planning.control_torque import face_distances
from skylimb.control.planning.vectoring import PURPOSES, VectoringTable, vectoring_table
from skylimb.control.planning.vectoring_criteria import TORQUE
from skylimb.control.planning.vectoring_digest import robot_digest
from skylimb.control.planning.vectoring_search import no_path
from skylimb.robots import SHIPPED, Robot, list_robots, load_robot

ROBOT = load_robot("hydrus_xi_quad")
TABLE = vectoring_table(ROBOT)
THETAS = np.linspace(0.20, 1.25, 211)


@pytest.fixture(scope="module")
def searched():
    """A search from nothing, once for all tests."""
    return vectoring_table(ROBOT, cache=False)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """An empty cache folder and an empty memory."""
    monkeypatch.setattr("platformdirs.user_cache_path", lambda name: tmp_path / name)
    monkeypatch.setattr(vectoring_files, "_known", {})
    monkeypatch.setattr(vectoring_files, "SHIPPED", tmp_path / "no_robots")
    return tmp_path / "skylimb" / "vectoring"


def elsewhere(robot):
    """The same robot from a folder without a table."""
    return Robot(replace(robot.description, folder=robot.description.folder / "none"))


# Guaranteed control torque


def test_a_cube_of_torques():
    rows = np.hstack([np.diag([1.0, 2.0, 3.0]), -np.diag([1.0, 2.0, 3.0])])
    assert guaranteed_torque(rows, 5.0) == pytest.approx(5.0)
    assert guaranteed_torque(np.vstack([np.ones((3, 6)), rows]), 5.0) == pytest.approx(5.0)
    assert guaranteed_torque(rows, [5, 1, 1, 9, 9, 9]) == pytest.approx(2.0)


def test_torque_that_some_direction_lacks_is_zero():
    assert guaranteed_torque(np.diag([1.0, 2.0, 3.0]), 5.0) == 0.0
    assert guaranteed_torque(np.ones((3, 4)), 5.0) == 0.0


@given(st.integers(0, 10**6), st.integers(4, 6))
def test_it_is_the_least_torque_over_all_directions(seed, n):
    rng = np.random.default_rng(seed)
    rows, limits = rng.normal(size=(3, n)), rng.uniform(0.5, 2.0, n)
    found = guaranteed_torque(rows, limits)
    directions = rng.normal(size=(3, 2000))
    directions /= np.linalg.norm(directions, axis=0)
    support = np.sum(np.maximum(directions.T @ (rows * limits), 0.0), axis=1)
    assert np.min(support) >= found - 1e-12
    # A torque just inside can be given in the worst direction found, by a linear program.
    worst = directions[:, np.argmin(support)] * found * 0.999
    solution = linprog(np.zeros(n), A_eq=rows, b_eq=worst, bounds=[(0.0, limit) for limit in limits])
    assert solution.status == 0


def test_expressions_for_the_search_bound_it_from_above_by_their_rounding():
    rows = ROBOT.at([np.pi / 3, np.pi / 3, -np.pi / 6], TABLE.angles(np.pi / 6)).allocation_C[3:]
    exact = guaranteed_torque(rows, 30.0)
    rounded = np.min(ca.DM(face_distances(ca.DM(rows), [30.0] * 4, 1e-4)).full())
    assert exact <= rounded <= exact + 1.01e-4


# The table of the robot


def test_the_branch_is_continuous_and_slow():
    slope = TABLE.slope(THETAS)
    assert np.max(np.abs(slope)) <= TORQUE.slope <= 2.0
    steps = np.diff(TABLE.angles(THETAS), axis=0)
    assert np.max(np.abs(steps)) <= TORQUE.slope * (THETAS[1] - THETAS[0]) * 1.001


def test_the_slope_is_the_derivative():
    step = 1e-5
    difference = (TABLE.angles(THETAS[1:-1] + step) - TABLE.angles(THETAS[1:-1] - step)) / (2 * step)
    np.testing.assert_allclose(TABLE.slope(THETAS[1:-1]), difference, atol=1e-6)


def test_hover_needs_no_tilt_and_thrusts_are_within_limits():
    assert np.max(tilt_along(ROBOT, TABLE, THETAS)) < 1e-3
    for theta, psi in zip(THETAS, TABLE.angles(THETAS), strict=True):
        thrusts = ROBOT.at([np.pi / 2 - theta, 2 * theta, -theta], psi).hover_thrusts
        assert np.all((thrusts > 5.0) & (thrusts < 20.0))


def test_guaranteed_torque_over_the_range():
    """3.3 .. 5.0 N m with the URDF's 35.5 N a rotor; the description has the motor table's 30 N."""
    torque = torque_along(ROBOT, TABLE, THETAS)
    np.testing.assert_allclose([torque.min() * 35.5 / 30, torque.max() * 35.5 / 30], [3.3, 5.0], atol=0.1)
    nominal = ROBOT.at([np.pi / 3, np.pi / 3, -np.pi / 6], TABLE.angles(np.pi / 6))
    np.testing.assert_allclose(nominal.hover_thrusts, [8.8, 13.2, 10.6, 10.5], atol=0.1)


@pytest.mark.parametrize(
    "theta", [1.1, *(pytest.param(theta, marks=pytest.mark.slow) for theta in (0.3, 0.5236, 0.8))]
)
def test_nearby_angles_without_tilt_have_no_more_torque(searched, theta):
    """Along the branch the table is within a few per cent of the best that its surroundings offer."""
    from scipy.optimize import NonlinearConstraint, minimize

    q = [np.pi / 2 - theta, 2 * theta, -theta]

    def lost(psi):
        return -guaranteed_torque(ROBOT.at(q, psi).allocation_C, 30.0)

    level = NonlinearConstraint(lambda psi: ROBOT.at(q, psi).R_root_C[:2, 2], -1e-3, 1e-3)
    start = searched.angles(theta)
    better = minimize(
        lost, start, method="COBYLA", constraints=[level], options={"rhobeg": 0.1, "maxiter": 300}
    )
    assert lost(start) <= 0.95 * better.fun


def test_the_shipped_table_is_what_the_search_finds(searched):
    assert searched.digest == TABLE.digest
    np.testing.assert_allclose(TABLE.coefficients, searched.coefficients, atol=1e-5)


def test_symbols_give_what_numbers_give_and_are_held_inside():
    x = ca.SX.sym("x")
    f = ca.Function("f", [x], [TABLE.angles(x), TABLE.slope(x)])
    for theta in np.linspace(0.2, 1.25, 9):
        angles, slope = f(theta)
        np.testing.assert_allclose(angles.full().ravel(), TABLE.angles(theta), atol=1e-13)
        np.testing.assert_allclose(slope.full().ravel(), TABLE.slope(theta), atol=1e-12)
    np.testing.assert_allclose(f(0.0)[0].full().ravel(), TABLE.angles(0.2), atol=1e-13)
    np.testing.assert_allclose(f(2.0)[0].full().ravel(), TABLE.angles(1.25), atol=1e-13)
    assert ca.Function("g", [x], [TABLE.angles(x)]).n_instructions() <= 110


def test_shapes():
    assert TABLE.angles(0.5).shape == (4,)
    assert TABLE.angles(np.full((2, 3), 0.5)).shape == (2, 3, 4)


@pytest.mark.parametrize("theta", [0.1, 1.3, np.nan])
def test_angles_outside_of_the_range_are_refused(theta):
    with pytest.raises(
        UnreachableError, match=r"outside of 0.2 .. 1.25 rad .where vectoring angles are known"
    ):
        TABLE.angles(theta)


# Digest and cache


def test_the_digest_follows_the_mechanics_only():
    d = ROBOT.description
    assert robot_digest(Robot(replace(d, name="other", digest="", rotors=d.rotors))) == TABLE.digest
    slower = tuple(replace(rotor, lag=0.1) for rotor in d.rotors)
    assert robot_digest(Robot(replace(d, rotors=slower))) == TABLE.digest
    weaker = tuple(replace(rotor, thrust_max=28.0) for rotor in d.rotors)
    assert robot_digest(Robot(replace(d, rotors=weaker))) != TABLE.digest
    heavier = tuple(
        replace(link, inertial=replace(link.inertial, mass=1.01 * link.inertial.mass))
        if link.name == "link2"
        else link
        for link in d.links
    )
    assert robot_digest(Robot(replace(d, links=heavier))) != TABLE.digest


def test_a_robot_with_a_table_beside_it_needs_no_search(cache, monkeypatch):
    monkeypatch.setattr(vectoring_files, "search_vectoring", None)
    np.testing.assert_array_equal(vectoring_table(ROBOT).coefficients, TABLE.coefficients)
    assert not cache.exists()


def test_a_search_is_kept_and_used_again(cache, monkeypatch):
    calls = []
    monkeypatch.setattr(
        vectoring_files, "search_vectoring", lambda robot, criteria: calls.append(1) or TABLE.coefficients
    )
    robot = elsewhere(ROBOT)
    vectoring_table(robot)
    assert [path.name for path in cache.glob("*.toml")] == [f"{TABLE.digest[:32]}.toml"]
    monkeypatch.setattr(vectoring_files, "_known", {})
    np.testing.assert_array_equal(vectoring_table(robot).coefficients, TABLE.coefficients)
    assert len(calls) == 1


@pytest.mark.parametrize(
    "text",
    [
        "coefficients = [[",
        "digest = 'other'\ncoefficients = [[0.0], [0.0], [0.0], [0.0]]",
        "digest = 'DIGEST'\ncoefficients = [[0.0]]",
        "digest = 'DIGEST'\ncoefficients = [[nan], [0.0], [0.0], [0.0]]",
        "digest = 'DIGEST'\ncoefficients = 'none'",
        "digest = 'DIGEST'",
        "\xff\xfe",
    ],
)
def test_a_damaged_cache_is_searched_anew_and_replaced(cache, monkeypatch, text):
    cache.mkdir(parents=True)
    file = cache / f"{TABLE.digest[:32]}.toml"
    file.write_bytes(text.replace("DIGEST", TABLE.digest).encode("latin-1"))
    monkeypatch.setattr(vectoring_files, "search_vectoring", lambda robot, criteria: TABLE.coefficients)
    np.testing.assert_array_equal(vectoring_table(elsewhere(ROBOT)).coefficients, TABLE.coefficients)
    assert TABLE.digest in file.read_text(encoding="utf-8")


def test_a_bit_that_flipped_in_the_cache_is_searched_anew(cache, monkeypatch):
    monkeypatch.setattr(vectoring_files, "search_vectoring", lambda robot, criteria: TABLE.coefficients)
    vectoring_table(elsewhere(ROBOT))
    file = cache / f"{TABLE.digest[:32]}.toml"
    kept = file.read_bytes()
    file.write_bytes(kept.replace(b".0", b".1", 1))
    monkeypatch.setattr(vectoring_files, "_known", {})
    with pytest.warns(UserWarning, match="damaged since it was kept"):
        np.testing.assert_array_equal(vectoring_table(elsewhere(ROBOT)).coefficients, TABLE.coefficients)
    assert file.read_bytes() == kept


def test_that_there_is_no_path_is_searched_once(cache, monkeypatch):
    calls = []

    def search(robot, criteria):
        calls.append(robot)
        raise no_path(robot, criteria)

    monkeypatch.setattr(vectoring_files, "search_vectoring", search)
    for _ in range(2):
        with pytest.raises(AllocationError, match="no continuous vectoring angles"):
            vectoring_table(elsewhere(ROBOT))
        monkeypatch.setattr(vectoring_files, "_known", {})
    assert len(calls) == 1


@pytest.mark.parametrize("purpose", PURPOSES)
@pytest.mark.parametrize("name", list_robots())
def test_for_every_robot_that_ships_the_search_was_done(cache, monkeypatch, name, purpose):
    monkeypatch.setattr(vectoring_files, "search_vectoring", lambda robot, criteria: np.zeros((0, 8)))
    monkeypatch.setattr(vectoring_files, "SHIPPED", SHIPPED)
    robot = load_robot(name)
    with suppress(AllocationError):  # that there is no path is known at once as well
        vectoring_table(robot, purpose)
    assert not cache.exists()


def test_a_cache_that_cannot_be_written_is_said_and_does_no_harm(cache, monkeypatch, caplog):
    cache.parent.mkdir(parents=True)
    cache.write_text("a file where the folder should be")
    monkeypatch.setattr(vectoring_files, "search_vectoring", lambda robot, criteria: TABLE.coefficients)
    with caplog.at_level(logging.WARNING):
        np.testing.assert_array_equal(vectoring_table(elsewhere(ROBOT)).coefficients, TABLE.coefficients)
    assert "cannot keep the vectoring angles" in caplog.text


# Other robots


def fixed_rotors() -> Robot:
    """The robot with its gimbals locked at the angles that the table gives at the nominal posture."""
    d, psi = ROBOT.description, TABLE.angles(np.pi / 6)
    joints = []
    for joint in d.joints:
        if joint.name in d.vectoring_joints:
            c, s = (
                np.cos(psi[d.vectoring_joints.index(joint.name)]),
                np.sin(psi[d.vectoring_joints.index(joint.name)]),
            )
            turned = joint.R @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
            joints.append(replace(joint, kind="fixed", R=turned))
        else:
            joints.append(joint)
    return Robot(replace(d, joints=tuple(joints), vectoring_joints=(), vectoring_start=np.zeros(0)))


def test_a_robot_without_vectoring_has_an_empty_table(cache):
    robot = fixed_rotors()
    expected = ROBOT.at([np.pi / 3, np.pi / 3, -np.pi / 6], TABLE.angles(np.pi / 6))
    np.testing.assert_allclose(
        robot.at([np.pi / 3, np.pi / 3, -np.pi / 6], []).allocation_C, expected.allocation_C, atol=1e-12
    )
    table = vectoring_table(robot)
    assert isinstance(table, VectoringTable)
    assert table.angles(0.5).shape == (0,)
    assert table.angles(np.array([0.4, 0.5])).shape == (2, 0)
    assert table.angles(ca.SX.sym("x")).shape == (0, 1)
    nominal = np.array([np.pi / 6])
    assert torque_along(robot, table, nominal) == pytest.approx(torque_along(ROBOT, TABLE, nominal), abs=1e-9)


@pytest.mark.parametrize(("name", "postures"), [("hydrus_xi_quad", 4), ("tiltable_hexarotor", 1)])
def test_what_does_not_bend_is_searched_in_one_posture(name, postures, monkeypatch):
    """All of its postures are the same, and each search takes as long."""
    asked = []
    monkeypatch.setattr(vectoring_search, "searches", lambda *given, p, **bounds: asked.append(p) or [])
    robot = load_robot(name)
    assert vectoring_search._starts(robot, vectoring_search.posture_function(robot, TORQUE)) == []
    assert len(set(asked)) == len(asked) == postures


def test_a_robot_that_cannot_hover_along_its_postures_is_refused():
    d = ROBOT.description
    weak = tuple(replace(rotor, thrust_max=10.2) for rotor in d.rotors)
    with pytest.raises(
        AllocationError, match="no continuous vectoring angles of 'hydrus_xi_quad' hover without tilt"
    ):
        vectoring_table(Robot(replace(d, rotors=weak)), cache=False)
