"""The nonlinear programme of `robots.equilibrium`, in CasADi's expressions."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import casadi as ca

from skylimb.base.rotations import rot_z
from skylimb.base.statics import rest_function
from skylimb.robots.loads import loads_function
from skylimb.robots.model import Robot
from skylimb.symbolic import right_inverse

_PRICE = 1e3
"""Of limits that give way by their whole size; 1 is a push of the weight, or 1 N m of margin."""

_COARSE = 0.05
"""A limit on tilt gives way by a share of no less than this, as the sine of the tilt."""


class Programme(NamedTuple):
    """The programme of a robot.

    Attributes:
        solver: x is lean, thrusts, psi, bends of the joints, t, h, e; p is q, d, the sine of the greatest
            tilt, thrusts for 1 of h, and what t (of the weight) and h are worth.
        torques: (x, q, d) -> torques on shape and vectoring joints, N m.
        limits: how many rows of g are limits: thrusts, servos, tilt.
    """

    solver: ca.Function
    torques: ca.Function
    limits: int


@functools.lru_cache(maxsize=16)
def programme_of(robot: Robot, *, levers: bool) -> Programme:
    """The programme; with `levers` thrusts for 1 of h are those of the angles, not those that p gives."""
    nq, nv, n = robot.n_joints, robot.n_vectoring, robot.n_rotors
    description, weight = robot.description, robot.weight
    low, high = robot.thrust_limits()
    servo, most = description.shape_servos, description.servos.torque_limit
    lean, thrusts, psi = ca.SX.sym("lean", 2), ca.SX.sym("thrusts", n), ca.SX.sym("psi", nv)
    bend, t, h, e = ca.SX.sym("bend", nq), ca.SX.sym("t"), ca.SX.sym("h"), ca.SX.sym("e")
    q, d, size = ca.SX.sym("q", nq), ca.SX.sym("d", 3), ca.SX.sym("size")
    spare, worth = ca.SX.sym("spare", n), ca.SX.sym("worth", 2)
    left, torques = rests(robot, q + bend, psi, lean, thrusts, t * d)
    given = torques / most
    if levers:
        torque = right_inverse(loads_function(robot)(q + bend, psi)[0][2:, :])[:, 1:]
        needed = ca.sqrt(ca.sum2(torque * torque))
    else:
        needed = spare
    # (sine of the angle from the vertical)^2
    leant = ca.sin(lean[0]) ** 2 + (ca.cos(lean[0]) * ca.sin(lean[1])) ** 2
    rows = [
        (thrusts - high + h * needed) / (high - low) - e,
        (low - thrusts + h * needed) / (high - low) - e,
        given - e,
        -given - e,
        (leant - size**2) / ca.fmax(size, _COARSE) ** 2 - e,
    ]
    x = ca.vertcat(lean, thrusts, psi, bend, t, h, e)
    bent = (servo.stiffness * bend - torques[:nq, :]) / servo.torque_limit
    limits = ca.vertcat(*rows)
    problem = {
        "x": x,
        "p": ca.vertcat(q, d, size, spare, worth),
        "f": _PRICE * e - worth[0] * t / weight - worth[1] * h,
        "g": ca.vertcat(left / weight, bent, limits),
    }
    options = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": False, "error_on_fail": False}
    options |= {"ipopt.max_iter": 200}
    return Programme(
        ca.nlpsol("held", "ipopt", problem, options),
        ca.Function("torques", [x, q, d], [torques], {"cse": True}),
        int(limits.shape[0]),
    )


def rests(robot: Robot, q: Any, psi: Any, lean: Any, thrusts: Any, push: Any) -> tuple[Any, Any]:
    """What is left over of force and torque, (6,), and torques on all joints, for CasADi's expressions.

    The push is in the level frame whose x axis is the heading.
    """
    C, V, J_c, J_r, r, heading = loads_function(robot)(q, psi)
    pushed = ca.SX(rot_z(heading)) @ push
    function = rest_function(robot.n_rotors, robot.n_joints + robot.n_vectoring)
    return function(C, V, J_c, J_r, r, robot.weight, lean, thrusts, pushed)
