"""The vectoring angles for contact: what they keep over all postures that can be flown."""

from dataclasses import replace

import numpy as np
import pytest

from guaranteed_torque import tilt_along, torque_along
from skylimb.base.errors import ConfigError, UnreachableError
from skylimb.control.planning import vectoring_files
from skylimb.control.planning.lateral_effort import lateral_effort
from skylimb.control.planning.posture import posture_family, standing
from skylimb.control.planning.tip_force import tip_force_map
from skylimb.control.planning.vectoring import nominal_posture, vectoring_table
from skylimb.control.planning.vectoring_criteria import CONTACT, TORQUE, VectoringCriteria
from skylimb.control.planning.vectoring_digest import robot_digest
from skylimb.robots import Robot, load_robot

DESCRIBED = load_robot("hydrus_xi_quad")
ROBOT = standing(DESCRIBED, "contact")
TABLE = vectoring_table(DESCRIBED, "contact")
FAMILY = posture_family(ROBOT)
THETAS = np.linspace(FAMILY.theta_min, FAMILY.theta_max, 101)


@pytest.fixture(scope="module")
def states():
    return [ROBOT.at(FAMILY.joint_angles(theta), TABLE.angles(theta)) for theta in THETAS]


@pytest.fixture(scope="module")
def X(states):
    return np.array([tip_force_map(state) for state in states])


def test_a_push_across_the_surface_stays_out_of_the_pressing_force(X):
    assert np.max(np.abs(X[:, 0, 1:])) <= 1.05 * CONTACT.leak
    assert np.max(np.abs(X[:, 0, 0] - 1.0)) <= 0.01
    before, family = vectoring_table(DESCRIBED), posture_family(DESCRIBED)
    torque = [tip_force_map(ROBOT.at(family.joint_angles(at), before.angles(at))) for at in THETAS[::10]]
    assert np.min(np.abs(np.array(torque)[:, 0, 1])) > 1.1  # what the other table lets through


def test_a_push_to_one_side_never_drives_the_robot_to_the_other(X):
    assert np.min(X[:, 1, 1]) >= 0.05
    assert np.max(np.abs(X[:, 1, 0])) <= 0.05
    assert np.all((X[:, 1, 2] < -0.1) & (X[:, 1, 2] > -0.30))


def test_torque_tilt_slope_and_thrusts(states):
    assert np.min(torque_along(ROBOT, TABLE, THETAS)) >= 3.0
    assert np.max(tilt_along(ROBOT, TABLE, THETAS)) <= 1.01 * CONTACT.tilt
    assert np.max(np.abs(TABLE.slope(THETAS))) <= 1.9 < CONTACT.slope
    thrusts = np.array([state.hover_thrusts for state in states])
    assert thrusts.min() > 8.5
    assert thrusts.max() < 14.5


def test_the_price_is_vectoring_that_hardly_pushes_sideways():
    effort = [lateral_effort(ROBOT, FAMILY.joint_angles(at), TABLE.angles(at)) for at in THETAS[::5]]
    assert np.all(np.array(effort) < [0.7, 1.65])


def test_it_covers_the_postures_within_the_joint_limits():
    assert (TABLE.theta_min, TABLE.theta_max) == (FAMILY.theta_min, FAMILY.theta_max)
    with pytest.raises(UnreachableError, match=r"shape angle 0.9.* rad of .* is outside of 0.2 .. 0.785 rad"):
        TABLE.angles(0.9)


def test_for_contact_it_stands_mirrored_with_its_other_end_where_it_was():
    """So are its vectoring angles, nearly: only the rotors' spins tell the sides apart."""
    q, psi = nominal_posture(DESCRIBED, "contact")
    np.testing.assert_allclose(q, -DESCRIBED.nominal_posture(), atol=1e-12)
    assert standing(ROBOT, "contact") is ROBOT
    assert standing(DESCRIBED, "torque") is DESCRIBED
    here, there = DESCRIBED.at(q, psi), DESCRIBED.at(-q, -psi)
    flip = np.array([1.0, -1.0, 1.0])
    np.testing.assert_allclose(here.tip_root, flip * there.tip_root, atol=1e-3)
    forces = [state.allocation_C[:3].sum(axis=1) for state in (here, there)]
    np.testing.assert_allclose(forces[0], flip * forces[1], atol=0.1)


def test_the_table_for_torque_is_the_old_one():
    table = vectoring_table(DESCRIBED, "torque")
    assert table.digest == robot_digest(DESCRIBED) == robot_digest(DESCRIBED, TORQUE)
    assert table.digest == "dbe82d477189d9a3bc458d01a9c2ec46dd2080da9b6520801415f37302e472fa"
    np.testing.assert_array_equal(table.coefficients, vectoring_table(DESCRIBED).coefficients)
    assert (table.theta_min, table.theta_max) == (0.2, 1.25)


def test_the_digest_follows_the_criteria_and_the_tip():
    d = ROBOT.description
    moved = Robot(replace(d, tip=replace(d.tip, position=1.01 * d.tip.position)))
    assert robot_digest(moved) == robot_digest(ROBOT)
    changes = {"leak": 0.2, "sideways": -1.0, "effort": 2.0, "thrust_margin": 0.1, "reachable": False}
    others = [replace(CONTACT, **{name: value}) for name, value in changes.items()]
    digests = [robot_digest(moved, CONTACT), *(robot_digest(ROBOT, criteria) for criteria in others)]
    assert len({*digests, TABLE.digest, robot_digest(ROBOT)}) == len(digests) + 2


def test_a_pen_that_points_up_gets_the_table_of_a_level_one_at_its_foot():
    mast = standing(load_robot("hydrus_xi_quad_mast"), "contact")
    contact = vectoring_table(mast, "contact")
    d = mast.description
    level = Robot(replace(d, tip=replace(d.tip, position=d.tip.stem)))
    assert contact.digest == robot_digest(level, CONTACT) != robot_digest(mast, CONTACT)
    np.testing.assert_allclose(contact.angles(0.5), TABLE.angles(0.5), atol=0.05)
    X = tip_force_map(mast.at(FAMILY.joint_angles(0.5), contact.angles(0.5)))
    np.testing.assert_allclose(X[2], [0.0, 0.0, 1.0], atol=1e-12)  # nothing leaks along z anyway


@pytest.mark.parametrize(("purpose", "slowest"), [("torque", 12.2), ("contact", 17.3)])
def test_the_side_force_of_a_tilt_has_a_zero_in_the_right_half_plane(purpose, slowest):
    """F = (m g + S J s^2 E) theta is zero at s^2 = -m g / eig(S J E). The attitude loop reaches 12 rad/s."""
    mast = load_robot("hydrus_xi_quad_mast")
    state = mast.at(*nominal_posture(mast, purpose))
    S = state.allocation_C[:2] @ np.linalg.pinv(state.allocation_C[2:])[:, 1:]
    worst = np.linalg.eigvals(S @ state.inertia_C[:, :2] @ [[0.0, -1.0], [1.0, 0.0]]).real.min()
    assert np.sqrt(9.81 * state.mass / -worst) == pytest.approx(slowest, rel=0.02)


def test_a_table_is_written_and_read_again(tmp_path, monkeypatch):
    monkeypatch.setattr("platformdirs.user_cache_path", lambda name: tmp_path / name)
    monkeypatch.setattr(vectoring_files, "_known", {})
    monkeypatch.setattr(vectoring_files, "SHIPPED", tmp_path / "no_robots")
    monkeypatch.setattr(vectoring_files, "search_vectoring", lambda robot, criteria: TABLE.coefficients)
    robot = Robot(replace(ROBOT.description, folder=tmp_path))
    first = vectoring_table(robot, "contact")
    monkeypatch.setattr(vectoring_files, "_known", {})
    monkeypatch.setattr(vectoring_files, "search_vectoring", None)
    again = vectoring_table(robot, "contact")
    np.testing.assert_array_equal(first.coefficients, again.coefficients)
    assert (again.theta_min, again.theta_max) == (TABLE.theta_min, TABLE.theta_max)


def test_another_purpose_is_refused():
    with pytest.raises(
        ConfigError, match="'contakt' is not one of 'torque', 'contact', 'online'; did you mean 'contact'"
    ):
        vectoring_table(ROBOT, "contakt")


@pytest.mark.parametrize(
    "values",
    [
        {"degree": 2},
        {"tilt": 0.0},
        {"thrust_margin": 0.5},
        {"leak": 0.0},
        {"effort": np.nan},
        {"slope": -1.0},
    ],
)
def test_criteria_that_make_no_sense(values):
    with pytest.raises(ConfigError, match=rf"VectoringCriteria\.{next(iter(values))} = "):
        VectoringCriteria("mine", **values)
    with pytest.raises(ConfigError, match=r"sideways = inf must be below inf"):
        VectoringCriteria("mine", sideways=np.inf)


@pytest.mark.slow
def test_the_shipped_table_is_what_the_search_finds():
    searched = vectoring_table(ROBOT, "contact", cache=False)
    assert searched.digest == TABLE.digest
    np.testing.assert_allclose(TABLE.coefficients, searched.coefficients, atol=1e-4)


@pytest.mark.slow
def test_criteria_that_cannot_be_kept_are_said(caplog: pytest.LogCaptureFixture) -> None:
    """Such a robot flies with the angles of most torque, and what leaks is felt."""
    d = ROBOT.description
    weak = Robot(replace(d, rotors=tuple(replace(rotor, thrust_max=12.0) for rotor in d.rotors)))
    with caplog.at_level("WARNING"):
        table = vectoring_table(weak, "contact", cache=False)
    assert "hover with at most 0.1 rad of tilt and keep the pushes" in caplog.text
    torque = vectoring_table(weak, "torque", cache=False)
    np.testing.assert_array_equal(table.coefficients, torque.coefficients)
