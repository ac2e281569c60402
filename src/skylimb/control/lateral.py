"""Side force by small moves of the vectoring angles.

Lift and torque take all four thrusts. What is left over sideways, in the hovering frame's x and y, is a
function h of the vectoring angles: the force of those thrusts that give the wanted lift and torque. Tilting
the robot changes it slowly; turning the rotors by a few degrees changes it at once. One Gauss-Newton step
from the nominal angles,

    d_psi = J^T (J J^T + mu E)^-1 (f_xy - h(psi)),      J = dh/dpsi exactly,      |d_psi| <= limit,

cancels the leak of the rotational thrusts and gives the sliding axes a fast force.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import casadi as ca

from skylimb.config import require_choice, require_positive, require_range
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, clip, exp, matrix, right_inverse, stack


@dataclass(frozen=True)
class Vectoring:
    """How the vectoring angles are used.

    Attributes:
        purpose: which table of angles over the posture: "torque", the paper's, or "contact".
        move: whether small moves around them give side force.
        limit: greatest move of an angle, rad.
        damping: mu, N^2/rad^2; keeps moves small where they do little.
        lead: how many times faster than their servos, which lag, the angles are made to follow.
        cutoff: of the low pass on the moves, Hz; wishes are noisy.
        lift: whether the thrusts for a torque are chosen so that they do not lift.
    """

    purpose: str = "torque"
    move: bool = False
    limit: float = 0.5
    damping: float = 0.5
    cutoff: float = 1.0
    lift: bool = False
    lead: float = 1.0

    def __post_init__(self) -> None:
        require_choice("vectoring", "purpose", self.purpose, ("torque", "contact"))
        require_positive("vectoring", "limit", self.limit, "rad")
        require_range("vectoring", "lead", self.lead, 1.0, 10.0)
        require_positive("vectoring", "damping", self.damping, "N^2/rad^2")


@functools.lru_cache(maxsize=16)
def _side_force(robot: Robot) -> ca.Function:
    """(q, at, psi, lift, torque) -> h in N, (2,), and J in N/rad, (2, nv), both in {C} of the angles `at`."""
    q, psi = ca.SX.sym("q", robot.n_joints), ca.SX.sym("psi", robot.n_vectoring)
    at, lift, torque = ca.SX.sym("at", robot.n_vectoring), ca.SX.sym("lift"), ca.SX.sym("torque", 3)
    model = robot.model(q, psi)
    # {C} turns with psi: side force means the same axes before and after a move.
    turn = robot.model(q, at).R_root_C.T @ model.R_root_C
    Q = ca.diagcat(turn, turn) @ model.allocation_C
    thrusts = right_inverse(Q[2:, :]) @ ca.vertcat(lift, torque)
    side = Q[:2, :] @ thrusts
    return ca.Function("side_force", [q, at, psi, lift, torque], ca.cse([side, ca.jacobian(side, psi)]))


def lateral_move(
    robot: Robot,
    gains: Any,
    move: Array,
    joint_angles: Array,
    vectoring_angles: Array,
    force: Array,
    torque: Array,
    dt: float,
) -> tuple[Array, Array]:
    """Move of the vectoring angles, rad, (nv,), and the side force without any, C, N, (3,).

    Args:
        robot: the controller's model.
        gains: a `Vectoring`.
        move: of the last tick, rad, (nv,): each tick makes one Gauss-Newton step from there.
        joint_angles: q, rad.
        vectoring_angles: nominal psi of that posture, rad.
        force: wanted in C of the nominal angles, N.
        torque: wanted there, N m.
        dt: control period, s.
    """
    found = _side_force(robot)(joint_angles, vectoring_angles, vectoring_angles + move, force[2], torque)
    side, J = found
    a = J[0, :] @ J[0, :].T + gains.damping
    b = J[0, :] @ J[1, :].T
    d = J[1, :] @ J[1, :].T + gains.damping
    inverse = matrix([[d, -b], [-b, a]]) / (a * d - b * b)
    # The least move that gives what is missing, where the move so far counts for what it does alone.
    new = J.T @ (inverse @ (force[0:2] - side + J @ move))
    decay = exp(-2.0 * math.pi * gains.cutoff * dt)
    new = decay * move + (1.0 - decay) * clip(new, -gains.limit, gains.limit)
    return new, stack(side - J @ move, 0.0)
