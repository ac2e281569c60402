"""A wrench in all six directions by thrusts and vectoring angles together, near a nominal hover.

Six rows of Q(psi) lambda = w have more unknowns than rows where enough rotors turn. Of all thrusts and angles
that give the wrench, those nearest to the hover thrusts lambda_0 and the angles psi_0 of the plan are taken:
with x = (lambda - lambda_0, psi - psi_0), thrusts in shares of the weight, and one Gauss-Newton step a tick,

    x_new = B^T (B B^T + mu E)^-1 (w - Q(psi) lambda + B x),      B = d(Q(psi) lambda)/dx exactly.

Where a thrust or an angle is at its limit, the others make up for it: the nearest x within the limits is
taken (`control.box_least_squares`). A torque by the thrusts alone pushes DRAGON to the side with 5 to 12 N
for each N m; so taken it does not.
"""

from __future__ import annotations

import functools
from typing import Annotated, Any, NamedTuple

import casadi as ca

from skylimb.base.keys import Key, configuration
from skylimb.control.box_least_squares import nearest_in_box
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, clip, is_symbolic, solve_positive, stack


@configuration
class Pointing:
    """How far the vectoring angles move for a wrench."""

    limit: Annotated[float, Key("rad", "greatest move of an angle from its plan", above=0.0, high=3.2)] = 0.6
    rate: Annotated[float, Key("rad/s", "greatest speed of a move", above=0.0, high=100.0)] = 3.0
    damping: Annotated[
        float,
        Key("", "mu, which keeps moves small where they do little", above=0.0, high=1e3),
    ] = 0.003


class Pointed(NamedTuple):
    """Thrusts, N, (n,), and the move of the vectoring angles from their plan, rad, (nv,)."""

    thrusts: Array
    move: Array


def pointed(
    gains: Any, robot: Robot, before: Pointed, joint_angles: Array, plan: Array, wrench: Array, dt: float
) -> tuple[Pointed, Array]:
    """One step towards thrusts and angles that give a wrench, and the thrusts that the limits left out, N.

    Args:
        gains: a `Pointing`.
        robot: the controller's model.
        before: of the last tick.
        joint_angles: measured, rad.
        plan: psi_0, rad, (nv,).
        wrench: force and torque about the centre of gravity, root axes, N and N m, (6,).
        dt: control period, s.
    """
    n = len(robot.description.rotors)
    free, rows = pointing_function(robot)(
        joint_angles, plan, before.move, before.thrusts, wrench, gains.damping
    )
    lower, upper = robot.vectoring_limits()
    least, most = robot.thrust_limits()
    step = gains.rate * dt
    lower, upper = (
        clip(clip(limit - plan, -gains.limit, gains.limit), before.move - step, before.move + step)
        for limit in (lower, upper)
    )
    share = _share(robot)
    box = (stack(least / share, lower), stack(most / share, upper))
    # Where a thrust or an angle is at its limit, the others make up for it.
    given, _ = nearest_in_box(*rows.shape)(rows, free, *box)
    if not is_symbolic(joint_angles, plan, wrench):
        free, given = free.full().ravel(), given.full().ravel()
    return Pointed(share * given[:n], given[n:]), share * (free[:n] - given[:n])


@functools.lru_cache(maxsize=16)
def pointing_function(robot: Robot) -> ca.Function:
    """(q, psi_0, move, lambda, w, mu) -> thrusts in shares of the weight and moves, and how they count.

    Thrusts and moves, (n + nv,), are those without limits; rows: (6 + n + nv, n + nv).
    """
    n, nv = len(robot.description.rotors), robot.n_vectoring
    q, plan, move = ca.SX.sym("q", robot.n_joints), ca.SX.sym("plan", nv), ca.SX.sym("move", nv)
    thrusts, wrench, damping = ca.SX.sym("thrusts", n), ca.SX.sym("wrench", 6), ca.SX.sym("damping")
    share, psi = _share(robot), plan + move
    given = robot.wrench_function(q, psi) @ thrusts
    # Torques count by a lever of a metre; the damping is small beside both.
    B = ca.horzcat(ca.jacobian(given, thrusts), ca.jacobian(given, move) / share)
    hover = ca.vertcat(robot.model(q, plan).hover_thrusts / share, ca.DM.zeros(nv))
    x = ca.vertcat(thrusts / share, move) - hover
    missing = (wrench - given) / share + B @ x
    new = hover + B.T @ solve_positive(B @ B.T + damping * ca.SX.eye(6), missing)
    rows = ca.vertcat(B, ca.sqrt(damping) * ca.SX.eye(n + nv))
    return ca.Function("pointing", [q, plan, move, thrusts, wrench, damping], ca.cse([new, rows]))


def _share(robot: Robot) -> float:
    """A rotor's share of the weight, N."""
    return robot.weight / len(robot.description.rotors)
