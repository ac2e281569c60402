"""Inverse kinematics of the tip: what is reachable is reached within limits; what is not is said."""

import numpy as np
import pytest

from made_robots import chain, multirotor
from skylimb.base.errors import ConfigError, UnreachableError
from skylimb.control.planning.tip_pose import TipTarget, find_posture, null_space, tip_position
from skylimb.control.planning.vectoring_step import plan_vectoring
from skylimb.robots import load_robot

QUAD = load_robot("hydrus_xi_quad")
STILL = np.array(QUAD.description.vectoring_start)


@pytest.fixture(scope="module")
def dragon(tmp_path_factory):
    """Pitch and yaw joints: the tip leaves the plane."""
    return load_robot(chain(tmp_path_factory.mktemp("dragon"), bends=("0 1 0", "0 0 1")))


def within(robot, q):
    lower, upper = robot.joint_limits()
    return bool(np.all(q >= lower - 1e-6) and np.all(q <= upper + 1e-6))


def test_random_tips_are_reached_within_the_limits(dragon):
    rng = np.random.default_rng(1)
    lower, upper = dragon.joint_limits()
    psi = dragon.description.vectoring_start
    for _ in range(3):
        goal = tip_position(dragon, rng.uniform(0.6 * lower, 0.6 * upper), psi)
        q = find_posture(dragon, TipTarget(goal))
        np.testing.assert_allclose(tip_position(dragon, q, psi), goal, atol=1e-6)
        assert within(dragon, q)


def test_the_nearest_of_all_postures_is_taken():
    """Three joints and two conditions in the plane leave one freedom: no move along it comes nearer."""
    near = QUAD.nominal_posture() + np.array([0.1, -0.1, 0.15])
    goal = tip_position(QUAD, QUAD.nominal_posture(), STILL)
    q = find_posture(QUAD, TipTarget(goal), near)
    free = null_space(QUAD, q, STILL)
    assert free.shape == (3, 1)
    assert np.abs(free.T @ (q - near)) < 1e-5
    assert np.linalg.norm(q - near) <= np.linalg.norm(QUAD.nominal_posture() - near) + 1e-9


def test_moves_in_the_null_space_keep_the_tip(dragon):
    q, psi = 0.5 * np.ones(6), dragon.description.vectoring_start
    free = null_space(dragon, q, psi)
    assert free.shape == (6, 3)
    moved = tip_position(dragon, q + 1e-5 * free @ [1.0, -1.0, 0.5], psi)
    np.testing.assert_allclose(moved, tip_position(dragon, q, psi), atol=1e-9)


def test_the_elevation_of_the_tip_link_is_kept(dragon):
    psi = dragon.description.vectoring_start
    goal = tip_position(dragon, np.array([0.1, 0.8, -0.2, 0.8, 0.3, 0.2]), psi)
    q = find_posture(dragon, TipTarget(goal, elevation=0.3))
    x_axis = dragon.link_poses(q, psi)["link4"][1][:, 0]
    assert np.arcsin(x_axis[2]) == pytest.approx(0.3, abs=1e-6)
    np.testing.assert_allclose(tip_position(dragon, q, psi), goal, atol=1e-6)


def test_links_stay_apart():
    """A tip beside the first link: alone it folds the chain onto itself, with clearance it does not."""
    folded = np.array([1.5, 1.5, 1.5])
    goal = tip_position(QUAD, folded, STILL)

    def least(q):
        points = np.asarray(QUAD.skeleton(q, STILL))
        first, last = points[:2], points[-2:]
        shares = np.linspace(0.0, 1.0, 4)[:, None]
        one, other = (ends[0] + shares * (ends[1] - ends[0]) for ends in (first, last))
        return np.min(np.linalg.norm(one[:, None] - other[None], axis=2))

    assert least(find_posture(QUAD, TipTarget(goal), folded)) < 0.12
    try:
        assert least(find_posture(QUAD, TipTarget(goal, clearance=0.15), folded)) >= 0.15 - 1e-6
    except UnreachableError as error:
        pytest.fail(str(error))


def test_what_is_out_of_reach_is_said_with_the_nearest_tip():
    with pytest.raises(UnreachableError, match=r"\[3\.0, 0\.0, 0\.0\] m .* the nearest tip is \[") as caught:
        find_posture(QUAD, TipTarget(np.array([3.0, 0.0, 0.0])))
    assert "\n" not in str(caught.value)


def test_a_robot_that_does_not_bend_is_refused(tmp_path):
    with pytest.raises(ConfigError, match="no bending joints"):
        find_posture(load_robot(multirotor(tmp_path)), TipTarget(np.zeros(3)))
    with pytest.raises(ConfigError, match="near has 2 angles"):
        find_posture(QUAD, TipTarget(np.zeros(3)), np.zeros(2))


@pytest.mark.parametrize(
    ("target", "told"),
    [
        ({"position": [1.0, 0.0]}, r"position = \[1\.0, 0\.0\] .* 3 finite numbers \(m\)"),
        ({"position": [np.nan, 0.0, 0.0]}, "position = .*nan.* 3 finite numbers"),
        ({"position": "tip"}, "position = 'tip' of a tip's target"),
        ({"position": np.zeros(3), "elevation": 45.0}, "elevation = 45 rad .* within -pi/2 and pi/2"),
        ({"position": np.zeros(3), "elevation": np.nan}, "elevation = nan rad"),
        ({"position": np.zeros(3), "orientation": np.eye(2)}, "orientation = .* 3 x 3 finite numbers"),
    ],
)
def test_a_target_that_is_none_is_named(target, told):
    with pytest.raises(ConfigError, match=told):
        TipTarget(**target)


def test_angles_of_another_robot_are_refused():
    q, psi = QUAD.nominal_posture(), QUAD.description.vectoring_start
    for given, name in (((q[:2], psi), "joint_angles"), ((q, psi[:1]), "vectoring_angles")):
        for function in (tip_position, null_space, plan_vectoring):
            with pytest.raises(ConfigError, match=f"^{name} = .* of 'hydrus_xi_quad' must be"):
                function(QUAD, *given)
    assert not plan_vectoring(QUAD, [np.nan, *q[1:]], psi).feasible()
