"""Planar inverse kinematics: round trips, the choice of the elbow, limits, and longer chains."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from skylimb.errors import ConfigError, DescriptionError, UnreachableError
from skylimb.planning.planar import planar_chain, planar_inverse_kinematics
from skylimb.robots import Robot, load_robot

ROBOT = load_robot("hydrus_xi_quad")
CHAIN = planar_chain(ROBOT)
angle = st.floats(-1.57, 1.57)


def longer() -> Robot:
    """The same robot with a fourth shape joint, turning the other way, where the pen's clamp was."""
    d = ROBOT.description
    clamp = d.joint("pen_clamp")
    hinge = replace(
        clamp, kind="revolute", axis=np.array([0.0, 0.0, -1.0]), lower=-1.2, upper=1.2, effort=1.0, speed=1.0
    )
    return Robot(
        replace(
            d,
            joints=tuple(hinge if joint is clamp else joint for joint in d.joints),
            shape_joints=(*d.shape_joints, "pen_clamp"),
            tip=replace(d.tip, link="pen", position=np.array([0.2, 0.05, 0.0])),
        )
    )


LONGER = longer()


@given(angle, angle, angle)
def test_the_chain_agrees_with_the_model(q1, q2, q3):
    q = np.array([q1, q2, q3])
    tip, heading = CHAIN.forward(q)
    state = ROBOT.model(*map(np.array, (q, np.zeros(4))))
    np.testing.assert_allclose(tip, np.array(state.tip_root).ravel()[:2], atol=1e-12)
    assert heading == pytest.approx(float(state.tip_heading), abs=1e-12)
    np.testing.assert_allclose(CHAIN.jacobian(q)[:2], np.array(state.tip_jacobian)[:2], atol=1e-12)


@given(angle, st.floats(0.02, 1.57), angle, st.booleans())
def test_joint_angles_come_back(q1, bend, q3, left):
    q = np.array([q1, bend if left else -bend, q3])
    tip, heading = CHAIN.forward(q)
    found = planar_inverse_kinematics(ROBOT, tip, heading + 2 * np.pi, elbow="left" if left else "right")
    np.testing.assert_allclose(found, q, atol=1e-7)
    nearest = planar_inverse_kinematics(ROBOT, tip, heading, near=q)
    np.testing.assert_allclose(nearest, q, atol=1e-7)


@given(angle, angle, angle)
def test_any_solution_is_one_and_within_the_limits(q1, q2, q3):
    tip, heading = CHAIN.forward(np.array([q1, q2, q3]))
    found = planar_inverse_kinematics(ROBOT, tip, heading)
    reached, turned = CHAIN.forward(found)
    np.testing.assert_allclose(reached, tip, atol=1e-7)
    assert np.cos(turned - heading) == pytest.approx(1.0, abs=1e-12)
    lower, upper = ROBOT.joint_limits()
    assert np.all(found >= lower)
    assert np.all(found <= upper)


def test_both_elbows_of_one_pose():
    tip, heading = CHAIN.forward(np.array([0.6, -0.5, 0.4]))
    left = planar_inverse_kinematics(ROBOT, tip, heading, elbow="left")
    right = planar_inverse_kinematics(ROBOT, tip, heading, elbow="right")
    assert left[1] == pytest.approx(0.5)
    assert right[1] == pytest.approx(-0.5)
    np.testing.assert_allclose(CHAIN.forward(left)[0], CHAIN.forward(right)[0], atol=1e-12)


@settings(max_examples=25, deadline=None)
@given(angle, angle, angle, st.floats(-1.1, 1.1))
def test_a_longer_chain_is_solved_numerically(q1, q2, q3, q4):
    q = np.array([q1, q2, q3, q4])
    chain = planar_chain(LONGER)
    assume(np.linalg.svd(chain.jacobian(q), compute_uv=False)[-1] > 0.02)
    tip, heading = chain.forward(q)
    state = LONGER.model(*map(np.array, (q, np.zeros(4))))
    np.testing.assert_allclose(tip, np.array(state.tip_root).ravel()[:2], atol=1e-12)
    assert heading == pytest.approx(float(state.tip_heading), abs=1e-12)
    found = planar_inverse_kinematics(LONGER, tip, heading, near=q + 0.05)
    reached, turned = chain.forward(found)
    np.testing.assert_allclose(reached, tip, atol=1e-9)
    assert np.cos(turned - heading) == pytest.approx(1.0, abs=1e-12)
    lower, upper = LONGER.joint_limits()
    assert np.all((found >= lower) & (found <= upper))
    assert np.linalg.norm(found - q - 0.05) <= np.linalg.norm(np.full(4, 0.05)) + 1e-6


def test_what_cannot_be_reached_says_why():
    with pytest.raises(
        UnreachableError, match=r"its last joint would be 2.75 m from its first, possible is 0 .. 1.2 m"
    ):
        planar_inverse_kinematics(ROBOT, [4.0, 0.0], 0.0)
    with pytest.raises(UnreachableError, match=r"it needs joint\d at .* rad, limits are -1.57 .. 1.57 rad"):
        planar_inverse_kinematics(ROBOT, [0.7, 0.1], 3.0)
    tip, heading = planar_chain(LONGER).forward(np.array([0.0, 0.0, 0.0, 0.0]))
    with pytest.raises(UnreachableError, match="finds no joint angles within its limits"):
        planar_inverse_kinematics(LONGER, tip + np.array([0.1, 0.0]), heading)


@pytest.mark.parametrize(
    ("arguments", "options", "message"),
    [
        (([1.0], 0.0), {}, "two and one finite numbers"),
        (([1.0, np.nan], 0.0), {}, "two and one finite numbers"),
        (([1.0, 1.0], 0.0), {"near": [0.0]}, "must be 3 joint angles"),
        (([1.0, 1.0], 0.0), {"elbow": "up"}, "'left', 'right' or None"),
    ],
)
def test_wrong_arguments(arguments, options, message):
    with pytest.raises(ConfigError, match=message):
        planar_inverse_kinematics(ROBOT, *arguments, **options)


def test_chains_that_are_not_planar_or_not_in_order_are_refused():
    d = ROBOT.description
    tilted = tuple(
        replace(joint, axis=np.array([0.0, 1.0, 0.0])) if joint.name == "joint2" else joint
        for joint in d.joints
    )
    with pytest.raises(DescriptionError, match="'joint2' turns about"):
        planar_inverse_kinematics(Robot(replace(d, joints=tilted)), [1.0, 1.0], 0.0)
    swapped = Robot(replace(d, shape_joints=("joint2", "joint1", "joint3")))
    with pytest.raises(DescriptionError, match="in that order: joint1, joint2, joint3"):
        planar_inverse_kinematics(swapped, [1.0, 1.0], 0.0)
