"""Friction on a pen that slides while nobody sees it."""

import numpy as np
import pytest

import skylimb
from skylimb.base.rotations import rotation_from_quaternion
from skylimb.control.estimation.body_state import body_state
from skylimb.control.estimation.records import BodyState, zero_measurement
from skylimb.control.estimation.slip import FRICTION, LIGHT, slip_wrench

ROBOT, DT = skylimb.load_robot("hydrus_xi_quad"), 0.005
AXIS, PUSH = np.array([1.0, 0.0, 0.0]), np.array([-1.0, 0.3, 0.2])
NONE = np.zeros(ROBOT.n_joints + ROBOT.n_vectoring)


def body(velocity: np.ndarray, rates: np.ndarray, joints: np.ndarray, speeds: np.ndarray) -> BodyState:
    """A leaning robot, whose root moves and turns, by its angles and their speeds."""
    seen = zero_measurement(ROBOT.n_joints, ROBOT.n_vectoring)
    turned = np.array([0.98, 0.1, -0.05, 0.15])
    turned /= np.linalg.norm(turned)
    seen = seen._replace(quaternion=turned, velocity=velocity, angular_velocity=rates, joint_angles=joints)
    return body_state(ROBOT, seen, speeds)


def slip(seen: BodyState, speeds: np.ndarray = NONE, axis: np.ndarray = AXIS) -> np.ndarray:
    return np.asarray(slip_wrench(seen, speeds, ROBOT.n_joints, PUSH, axis, DT))


def test_it_goes_against_the_way_of_the_tip_with_the_joints_that_move_it_and_turns_the_robot() -> None:
    velocity, rates = np.array([0.1, -0.2, 0.15]), np.array([0.2, -0.1, 0.3])
    q, speeds = ROBOT.nominal_posture(), np.concatenate([[0.3, -0.2, 0.1], np.zeros(ROBOT.n_vectoring)])
    here = body(velocity, rates, q, speeds)
    wrench = slip(here, speeds)

    def tip(time: float) -> np.ndarray:
        model = ROBOT.at(q + time * speeds[:3], np.zeros(ROBOT.n_vectoring))
        R = here.R_WC @ here.model.R_root_C.T
        turn = rotation_from_quaternion(np.concatenate([[1.0], 0.5 * time * rates]))
        return velocity * time + R @ turn @ model.tip_root

    moving = (tip(1e-5) - tip(-1e-5)) / 2e-5
    most = FRICTION * 1.0
    slow = 0.01 + most * DT / LIGHT
    want = -most * moving / np.sqrt(moving @ moving + slow**2)
    np.testing.assert_allclose(wrench[:3], want, rtol=1e-4)
    np.testing.assert_allclose(wrench[3:], np.cross(here.model.tip_C, here.R_WC.T @ want), rtol=1e-4)


def test_a_drift_across_the_way_is_damped_and_a_tip_is_never_turned_round_within_a_tick() -> None:
    still = np.zeros(3)
    along, across = np.array([0.0, 0.5, 0.0]), np.array([0.0, 0.0, 0.01])
    q = ROBOT.nominal_posture()
    held = slip(body(along + across, still, q, NONE))[:3] - slip(body(along, still, q, NONE))[:3]
    np.testing.assert_allclose(held[2], -FRICTION * 0.01 / 0.5, rtol=0.01)
    for speed in (1e-6, 1e-3, 0.02, 1.0):
        force = slip(body(np.array([0.0, speed, 0.0]), still, q, NONE))
        assert 0.0 < -force[1] * DT / LIGHT <= speed


@pytest.mark.parametrize("axis", [np.zeros(3), -AXIS])
def test_where_nothing_pushes_back_nothing_rubs(axis: np.ndarray) -> None:
    seen = body(np.array([0.0, 0.2, 0.0]), np.zeros(3), ROBOT.nominal_posture(), NONE)
    np.testing.assert_array_equal(slip(seen, axis=axis), np.zeros(6))
