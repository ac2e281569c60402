"""The map from a force on the tip to the centre of gravity, against forces summed rotor by rotor."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skylimb.base.rotations import rot_z
from skylimb.control.allocation.thrusts import allocate
from skylimb.control.estimation.records import BodyState
from skylimb.control.planning.tip_force import tip_force_map
from skylimb.control.planning.vectoring import nominal_posture, vectoring_table
from skylimb.robots import load_robot

ROBOT = load_robot("hydrus_xi_quad")


def joints(theta):
    return np.array([np.pi / 2 - theta, 2 * theta, -theta])


def summed_by_hand(theta, psi, force):
    """Force on the centre of gravity, heading frame: each rotor's force and torque in the root frame."""
    state, poses = ROBOT.at(joints(theta), psi), ROBOT.link_poses(joints(theta), psi)
    to_root = state.R_root_C @ rot_z(state.tip_heading)
    axes, torques = [], []
    for rotor in ROBOT.description.rotors:
        point, R = poses[rotor.link]
        axis = (R @ rotor.R)[:, 2]
        arm = point + R @ rotor.xyz - state.cog_root
        axes.append(axis)
        torques.append(np.cross(arm, axis) + rotor.drag_torque_coefficient * axis)
    up, axes = state.R_root_C[:, 2], np.array(axes).T
    push = to_root @ force
    turned = np.cross(state.tip_root - state.cog_root, push)
    thrusts = np.linalg.solve(np.vstack([up @ axes, np.array(torques).T]), np.concatenate([[0.0], -turned]))
    return to_root.T @ (push + axes @ thrusts)


@given(st.integers(0, 10**6))
def test_it_is_the_sum_of_all_forces(seed):
    rng = np.random.default_rng(seed)
    theta = rng.uniform(0.2, 0.785)
    psi = vectoring_table(ROBOT).angles(theta) + rng.uniform(-0.3, 0.3, 4)
    force = rng.normal(size=3)
    X = tip_force_map(ROBOT.at(joints(theta), psi))
    np.testing.assert_allclose(X @ force, summed_by_hand(theta, psi, force), rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("purpose", ["torque", "contact"])
def test_the_cascade_holds_the_attitude_with_the_same_force(purpose):
    state = ROBOT.at(*nominal_posture(ROBOT, purpose))
    push = np.array([0.3, -0.8, 0.0])  # in {C}; a push along z would change the lift that is wanted
    weight = np.array([0.0, 0.0, state.mass * 9.80665])
    body = BodyState(np.zeros(3), np.zeros(3), np.eye(3), np.zeros(3), state)
    held = allocate(body, weight, -np.cross(state.tip_C, push), (np.zeros(4), np.full(4, 100.0))).total
    force = push + (state.allocation_C @ held)[:3] - (state.allocation_C @ state.hover_thrusts)[:3]
    turn = rot_z(state.tip_heading)
    # The least-norm thrusts for the torque may lift a little; that is along z of {C} and no sideways force.
    np.testing.assert_allclose((turn.T @ force)[:2], (tip_force_map(state) @ turn.T @ push)[:2], atol=1e-9)


def test_lift_is_held_and_symbols_say_the_same():
    q, psi = ca.SX.sym("q", 3), ca.SX.sym("psi", 4)
    f = ca.Function("f", [q, psi], [tip_force_map(ROBOT.model(q, psi))])
    angles = vectoring_table(ROBOT).angles(0.5)
    X = tip_force_map(ROBOT.at(joints(0.5), angles))
    np.testing.assert_allclose(f(joints(0.5), angles).full(), X, atol=1e-9)
    np.testing.assert_allclose(X[2], [0.0, 0.0, 1.0], atol=1e-12)
