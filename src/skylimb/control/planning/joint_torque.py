"""What the servos of the shape joints have to hold while the robot hovers.

Tilted rotors push against each other through the links. That costs no lift and turns nothing, so a margin of
thrust does not see it; a servo beyond its torque lets its joint go, and the allocation's model with it. With
{C} level, thrusts lambda_i along u_i at p_i and the centre of gravity at c, the torque on joint j is by
virtual work

    tau_j = sum_i lambda_i (u_i . dp_i/dq_j + kappa_i u_i . w_ij) - m g z . dc/dq_j,

with w_ij the turn of rotor i for a radian of joint j. All forces balance, so the root may be held for it.
A servo is a spring, so its joint comes to rest beside the command, at q_j + tau_j / k.
"""

from __future__ import annotations

import functools

import casadi as ca

from skylimb.robots.loads import thrust_lines
from skylimb.robots.model import Robot

_STEPS = 3


@functools.lru_cache(maxsize=16)
def joint_torque_function(robot: Robot) -> ca.Function:
    """(q, psi) -> torque of rotors and weight on each shape joint in hover, N m, (nq,)."""
    q, psi = ca.SX.sym("q", robot.n_joints), ca.SX.sym("psi", robot.n_vectoring)
    state = robot.model(q, psi)
    up = state.R_root_C[:, 2]
    torque = -robot.weight * (state.cog_jacobian[:, : robot.n_joints].T @ up)
    for thrust, line in zip(ca.vertsplit(state.hover_thrusts), thrust_lines(robot, q, psi, q), strict=True):
        torque += thrust * line.load
    return ca.Function("joint_torque", [q, psi], [torque], {"cse": True})


@functools.lru_cache(maxsize=16)
def rest_function(robot: Robot) -> ca.Function:
    """(q, psi) -> joint angles, rad, (nq,), at which servos commanded to q hold in hover.

    A fixed number of steps q_rest = q + tau(q_rest) / k; each leaves |d tau/dq| / k of the error before it, a
    tenth for DRAGON.
    """
    q, psi = ca.MX.sym("q", robot.n_joints), ca.MX.sym("psi", robot.n_vectoring)
    rest = q
    for _ in range(_STEPS if robot.n_joints else 0):
        rest = q + joint_torque_function(robot)(rest, psi) / robot.description.shape_servos.stiffness
    return ca.Function("rest", [q, psi], [rest])
