"""The mechanics that a prediction is made of, held against the robot's own model."""

from typing import Any

import casadi as ca
import numpy as np

from skylimb.robots.kinematics import body_poses
from skylimb.robots.loader import load_robot
from skylimb.studies.calibration.mechanics import layout, mechanics

ROBOT = load_robot("hydrus_xi_quad")
RNG = np.random.default_rng(3)
ANGLES = np.concatenate([RNG.uniform(0.2, 1.4, (4, 3)), RNG.uniform(-1.0, 1.0, (4, 4))], axis=1)
RATES = RNG.uniform(-0.5, 0.5, ANGLES.shape)


def test_it_is_the_robots_model() -> None:
    rows = mechanics(ROBOT, ANGLES, RATES)
    for k, angles in enumerate(ANGLES):
        made = layout(ROBOT.n_rotors).unpack(rows[k])
        state = ROBOT.at(angles[:3], angles[3:])
        R = state.R_root_C
        assert np.allclose(made.cog, state.cog_root)
        assert np.allclose(made.cog_rate, state.cog_jacobian @ RATES[k])
        assert np.allclose(R.T @ made.forces, state.allocation_C[:3])
        assert np.allclose(R.T @ made.torques, state.allocation_C[3:])
        moments = made.moments * ROBOT.mass
        assert np.allclose(R.T @ (np.trace(moments) * np.eye(3) - moments) @ R, state.inertia_C)


def test_the_joints_momentum_is_that_of_the_bodies() -> None:
    """Each body's motion from its places a moment before and after."""
    step = 1e-6
    names = [*ROBOT.description.shape_joints, *ROBOT.description.vectoring_joints]

    def places(angles: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        poses = body_poses(ROBOT.bodies, dict(zip(names, angles.tolist(), strict=True)))
        return [
            (numbers(pose.point(body.com)).ravel(), numbers(pose.turned(np.eye(3))))
            for body, pose in zip(ROBOT.bodies, poses, strict=True)
        ]

    rows = mechanics(ROBOT, ANGLES, RATES)
    for k, angles in enumerate(ANGLES):
        made = layout(ROBOT.n_rotors).unpack(rows[k])
        before, after = places(angles - step * RATES[k]), places(angles + step * RATES[k])
        total = np.zeros(3)
        for body, (c0, R0), (c1, R1) in zip(ROBOT.bodies, before, after, strict=True):
            R, W = 0.5 * (R0 + R1), (R1 - R0) @ R0.T / (2.0 * step)
            spin = np.array([W[2, 1], W[0, 2], W[1, 0]])
            lever = 0.5 * (c0 + c1) - made.cog
            total += body.mass * np.cross(lever, (c1 - c0) / (2.0 * step)) + R @ body.inertia @ R.T @ spin
        assert np.allclose(made.momentum * ROBOT.mass, total, atol=1e-6)


def numbers(constant: Any) -> np.ndarray:
    """A CasADi constant as numbers."""
    return np.asarray(ca.evalf(ca.SX(constant)).full())
