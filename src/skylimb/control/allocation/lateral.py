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
from typing import Annotated, Any

import casadi as ca
import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.control.records import Demand, LawInput
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, as_numpy, clip, low_pass, matrix, right_inverse, stack


@configuration
class Moves:
    """How far and how fast the angles move."""

    limit: Annotated[float, Key("rad", "greatest move of an angle", above=0.0, high=3.2)] = 0.5
    damping: Annotated[
        float,
        Key("N^2/rad^2", "mu, which keeps moves small where they do little", above=0.0, high=1e6),
    ] = 0.5
    cutoff: Annotated[
        float,
        Key("Hz", "cut-off of the low pass on the moves, as the wanted force is noisy", above=0.0, high=1e4),
    ] = 1.0
    lead: Annotated[
        float, Key("", "how many times faster than by their servos the angles follow", low=1.0, high=10.0)
    ] = 1.0


@functools.lru_cache(maxsize=16)
def side_force_function(robot: Robot) -> ca.Function:
    """(q, at, psi, lift, torque) -> h, J, g, c, of the thrusts that give lift (N) and torque (N m, {C}).

    h: their side force in {C} of the angles `at`, N, (2,). J = dh/dpsi, N/rad, (2, nv). g: gradient of
    |thrusts|^2 / 2 by psi with each thrust in shares of its rotor's greatest, 1/rad, (nv,). c: likewise, of
    their difference from the thrusts that give the lift alone at the angles `at`.
    """
    q, psi = ca.SX.sym("q", robot.n_joints), ca.SX.sym("psi", robot.n_vectoring)
    at, lift, torque = ca.SX.sym("at", robot.n_vectoring), ca.SX.sym("lift"), ca.SX.sym("torque", 3)
    model = robot.model(q, psi)
    # {C} turns with psi: side force means the same axes before and after a move.
    still = robot.model(q, at)
    turn = still.R_root_C.T @ model.R_root_C
    Q = ca.diagcat(turn, turn) @ model.allocation_C
    thrusts = right_inverse(Q[2:, :]) @ ca.vertcat(lift, torque)
    side = Q[:2, :] @ thrusts
    hover = still.hover_thrusts * (lift / robot.weight)
    most = ca.DM(robot.thrust_limits()[1])
    effort = ca.gradient(0.5 * ca.sumsqr(thrusts / most), psi)
    change = ca.gradient(0.5 * ca.sumsqr((thrusts - hover) / most), psi)
    outputs = ca.cse([side, ca.jacobian(side, psi), effort, change])
    return ca.Function("side_force", [q, at, psi, lift, torque], outputs)


def lateral_move(gains: Any, move: Array, inputs: LawInput, demand: Demand) -> tuple[Array, Array]:
    """Move of the vectoring angles, rad, (nv,), and the side force without any, C, N, (3,).

    Args:
        gains: a `Moves`.
        move: of the last tick, rad, (nv,): each tick makes one Gauss-Newton step from there.
        inputs: of this tick.
        demand: force, torque and nominal vectoring angles.
    """
    nominal, force = demand.vectoring_angles, inputs.estimate.body.R_WC.T @ demand.force
    found = side_force_function(inputs.robot)(
        inputs.measurement.joint_angles, nominal, nominal + move, force[2], demand.torque
    )
    side, J, *_ = map(as_numpy, found)
    # What is missing, where the move so far counts for what it does alone.
    new = least_move(J, gains.damping, force[0:2] - side + J @ move)
    new = clip(new, -gains.limit, gains.limit)
    lower, upper = inputs.robot.vectoring_limits()
    if np.isfinite(lower).any() or np.isfinite(upper).any():
        new = clip(new, lower - nominal, upper - nominal)
    new = low_pass(move, new, 2.0 * math.pi * gains.cutoff, inputs.dt)
    return new, stack(side - J @ move, 0.0)


def least_move(J: Array, damping: Any, side: Array) -> Array:
    """The least move that gives a side force, J^T (J J^T + mu E)^-1 f_xy, rad, (nv,).

    Args:
        J: side force per move, N/rad, (2, nv).
        damping: mu, N^2/rad^2.
        side: f_xy, N, (2,).
    """
    a = J[0, :] @ J[0, :].T + damping
    b = J[0, :] @ J[1, :].T
    d = J[1, :] @ J[1, :].T + damping
    return J.T @ (matrix([[d, -b], [-b, a]]) / (a * d - b * b) @ side)
