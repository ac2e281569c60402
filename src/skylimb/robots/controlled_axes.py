"""Which of lift and torques a robot's inputs can give in a hover, and which they cannot, by name."""

from __future__ import annotations

import casadi as ca
import numpy as np

from skylimb.robots.model import Robot

AXES = ("lift", "roll torque", "pitch torque", "yaw torque")
_RANK = 1e-6
_PUSHES = 1e-3
"""Least over greatest singular value from which on six directions of a wrench count as given."""
_SHARE = 0.5
"""An axis counts as not given where this share of it lies in what the inputs leave out."""


def inputs_at(
    robot: Robot, joint_angles: np.ndarray, vectoring_angles: np.ndarray, thrusts: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Wrench in root axes, N and N m, per newton of each thrust (6, n) and radian of each angle (6, nv).

    The second is how the wrench of some thrusts (n,), N, changes as the vectoring joints turn.
    """
    psi = ca.SX.sym("psi", robot.n_vectoring)
    wrench = robot.wrench_function(ca.DM(joint_angles), psi)
    moving = ca.jacobian(wrench @ ca.DM(thrusts), psi)
    inputs = ca.Function("inputs", [psi], [wrench, moving])(vectoring_angles)
    return inputs[0].full(), inputs[1].full()


def kind_of(robot: Robot) -> str:
    """What a robot is to a preset: "tilting" or "pushing" for a side force; "chain" or "vectoring".

    Those of two or three rotors, which are flown as pairs of fixed ones (`robots.turned_rotors`), tilt as
    "pairs" or push as "pushing_pairs": their sides are as slow as servos.

    A chain's links carry its rotors; with vectoring joints it is "vectoring". A multirotor whose arms turn
    counts as tilting: its body is as light, and its arms turn slowly.
    """
    if robot.turned is not None:
        kind = kind_of(robot.pairs)
        return {"tilting": "pairs", "pushing": "pushing_pairs"}.get(kind, kind)
    if robot.n_vectoring:
        return "vectoring" if carried_by_joints(robot) else "tilting"
    if carried_by_joints(robot):
        return "chain"
    wrench = robot.wrench_function(robot.nominal_posture(), np.zeros(0)).full()
    return "pushing" if np.linalg.matrix_rank(wrench, rtol=_PUSHES) == 6 else "tilting"


def carried_by_joints(robot: Robot) -> bool:
    """Whether a joint that bends the robot moves a rotor."""
    if not robot.n_joints:
        return False
    q, psi = robot.nominal_posture(), robot.description.vectoring_start
    still, bent = robot.link_poses(q, psi), robot.link_poses(q + 0.5, psi)
    return not all(np.allclose(bent[r.link][0], still[r.link][0]) for r in robot.description.rotors)


def not_given(matrix: np.ndarray) -> str:
    """In words, which of `AXES` no combination of a matrix's columns, (4, k), gives; empty for all four."""
    sizes = np.linalg.norm(matrix, axis=1, keepdims=True)
    rows = matrix / np.where(sizes > 1e-9, sizes, 1.0)
    left, values, _ = np.linalg.svd(rows, full_matrices=True)
    rank = int(np.count_nonzero(values > _RANK * max(float(values[0]), 1e-300)))
    shares = np.linalg.norm(left[:, rank:], axis=1)
    names = " and ".join(name for name, share in zip(AXES, shares, strict=True) if share > _SHARE)
    if np.count_nonzero(shares > _SHARE) <= len(AXES) - rank:
        return names
    return f"a combination of {names}"
