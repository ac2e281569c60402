"""Vectoring angles beside a part that is lost or astray: with them the robot stays level, or slow.

Rotors with vectoring are tilted: one whose servo turns on and on pushes to all sides in turn, and those on a
joint that gives way fold the arm. Three rotors that turn along make up for either, and for a fourth one that
is lost. For angles psi of theirs the best thrusts leave

    r(psi) = (w (A T - push), v (torque of limp joints), e (T - their mean))      with T of the least |r|,

with A the wrench of the rotors that are there, in level axes, and the push no more than lift beside a joint.
One damped Gauss-Newton step a tick takes |r| down,

    d_psi = -(J^T J + mu E)^-1 J^T r,      J = dr/dpsi exactly,

from where the angles are, so that they never jump from one balance to another. A servo that runs away is
taken where it will be once those of the others, which lag, have followed. Where a servo bends the arm to a
shape that nobody wanted, the angles of the nominal posture carry the robot on its side. A robot that has lost
a rotor leans before the others can turn it back, and slides to that side: there the push is upright, and
against its speed, which the angles give sooner than its attitude.
"""

from __future__ import annotations

import functools
from typing import Any

import casadi as ca
import numpy as np

from skylimb.control.estimation.prediction import parted
from skylimb.control.estimation.records import Measurement
from skylimb.control.estimation.servos import servo_lags
from skylimb.robots.loads import loads_function
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, abs, as_numpy, diagonal, max, solve_positive, where

COUNTS = np.array([1.0, 1.0, 3.0, 10.0, 10.0, 1.0])
"""What 1 N to either side and up, and 1 N m of roll, pitch and yaw count: yaw is given up first, as it only
turns the robot."""

PUSHED, EVEN = 1.0, 0.1
"""What 1 N m in a limp joint counts, and 1 N of a thrust beside the mean of all."""

DAMPING = 3.0
"""mu, N^2/rad^2: which keeps steps small where they do little."""

RATE = 3.5
"""Speed of the vectoring angles on their way to others, rad/s."""


def balanced(
    robot: Robot,
    loose: Array,
    astray: Any,
    there: Array,
    measured: Measurement,
    speeds: Array,
    axes: Array,
    push: Array,
    angles: Array,
    dt: float,
) -> Array:
    """Vectoring angles of a tick, rad, (nv,).

    Args:
        robot: the model.
        loose: 1 for each joint that no servo holds, of the shape and then of the vectoring, (nq + nv,).
        astray: 1 where a servo has turned a joint of the shape elsewhere, or the push is the reserve's.
        there: 1 for each rotor that is not lost, (n,).
        measured: that is believed.
        speeds: of all joints by it, rad/s, (nq + nv,).
        axes: of the measured link, that are level, (3, 3).
        push: that is wanted along them, N, (3,).
        angles: of the last tick, rad, (nv,).
        dt: control period, s.
    """
    if not robot.n_vectoring:
        return angles
    limp, runs = parted(loose, robot.n_joints)
    _, ahead = parted(speeds * servo_lags(robot), robot.n_joints)
    here = where(runs > 0.5, measured.vectoring_angles + ahead, angles)
    rest, J = map(as_numpy, _balance(robot)(measured.joint_angles, axes, here, limp, there, push))
    J = J @ diagonal(1.0 - runs)
    step = solve_positive(J.T @ J + DAMPING * np.eye(robot.n_vectoring), -(J.T @ rest))
    step = step * (RATE * dt / max(max(abs(step)), RATE * dt))
    return where(max(loose) + astray > 0.5, angles + step, angles)


@functools.lru_cache(maxsize=16)
def _balance(robot: Robot) -> ca.Function:
    """(q, axes, psi, limp, there, push) -> r of the best thrusts, and dr/dpsi."""
    n, nq = robot.n_rotors, robot.n_joints
    q, psi, limp = (
        ca.SX.sym(name, size) for name, size in (("q", nq), ("psi", robot.n_vectoring), ("limp", nq))
    )
    axes, there, push = ca.SX.sym("axes", 3, 3), ca.SX.sym("there", n), ca.SX.sym("push", 3)
    wrench, loads, *_ = loads_function(robot)(q, psi)
    rows = ca.vertcat(
        ca.diag(COUNTS) @ ca.diagcat(axes.T, axes.T) @ wrench @ ca.diag(there),
        ca.diag(PUSHED * limp) @ loads[:nq, :],
        EVEN * ca.DM.eye(n),
    )
    mean = np.full(n, EVEN * robot.weight / n)
    wanted = ca.vertcat(COUNTS[:3] * push, np.zeros(3 + nq), mean)
    rest = rows @ solve_positive(rows.T @ rows, rows.T @ wanted) - wanted
    outputs = ca.cse([rest, ca.jacobian(rest, psi)])
    return ca.Function("balance", [q, axes, psi, limp, there, push], outputs)
