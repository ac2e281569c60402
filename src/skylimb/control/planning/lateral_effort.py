"""How far the vectoring joints must turn for a small sideways force while the robot stays as it is."""

from __future__ import annotations

import functools
from typing import Any

import casadi as ca
import numpy as np

from skylimb.base.rotations import rot_z
from skylimb.robots import Robot
from skylimb.symbolic import Array, is_symbolic


def lateral_effort(robot: Robot, joint_angles: Any, vectoring_angles: Any) -> Array:
    """Turn of the vectoring joints for a newton along x and along y of the tip's heading frame: (2,), rad/N.

    At hover, the net wrench (6) of the rotors changes with the thrusts and the vectoring angles by the
    Jacobian J (6, n + nv). The least-norm change [d_lambda; d_psi] = J^T (J J^T)^-1 [e; 0] gives a newton
    along e with neither lift nor torque; its norm counts a newton of thrust and a radian alike. |d_psi| of it
    is the answer. Much above 0.3 rad/N, tilting is the better way to push sideways. Where a radian
    counts as ten newtons of thrust, the contact table needs about half the turn, for 1 to 4 N of thrust.

    Args:
        robot: any robot with at least six thrusts and vectoring joints together.
        joint_angles: (nq,) q in rad, numbers or CasADi symbols.
        vectoring_angles: (nv,) psi in rad, numbers or CasADi symbols.
    """
    effort = _effort(robot)(joint_angles, vectoring_angles)
    return effort if is_symbolic(joint_angles, vectoring_angles) else effort.full().ravel()


@functools.lru_cache(maxsize=16)
def _effort(robot: Robot) -> ca.Function:
    q, psi = ca.SX.sym("q", robot.n_joints), ca.SX.sym("psi", robot.n_vectoring)
    thrusts = ca.SX.sym("thrusts", robot.n_rotors)
    state = robot.model(q, psi)
    # {C} turns with psi, so the wrench is differentiated in the root frame, which does not.
    R = state.R_root_C
    wrench = ca.vertcat(R @ state.allocation_C[:3, :] @ thrusts, R @ state.allocation_C[3:, :] @ thrusts)
    J = ca.jacobian(wrench, ca.vertcat(thrusts, psi))
    J = ca.substitute(J, thrusts, state.hover_thrusts)
    to_heading = (R @ rot_z(state.tip_heading)).T
    J = ca.vertcat(to_heading @ J[:3, :], to_heading @ J[3:, :])
    change = J.T @ ca.solve(J @ J.T, ca.DM(np.eye(6)[:, :2]))
    turn = change[robot.n_rotors :, :]
    return ca.Function("effort", [q, psi], [ca.sqrt(ca.sum1(turn * turn)).T], ["q", "psi"], ["effort"])
