"""How good vectoring angles are in a posture: what the rotors have left, and how level the robot hovers.

Margins, in N m:

- the distance of each face of the torques' zonotope from no torque, whose least is FCTmin
  (`planning.control_torque`),
- how far each hover thrust is from its limits, at the rotors' root mean square lever,
- how far each limited vectoring joint is from its ends, at `PER_RADIAN` of the robot's weight at that lever.

Their least is what counts, and it has no derivative where two are least. The merit takes the smooth minimum
in its place and charges for the tilt of the hover,

    M = -1/sharp log sum_i exp(-sharp d_i / s) - 1/2 TILT |tilt|^2 - 1/2 STRAIN |strain|^2,   s = m g lever.

Strain is the share of its torque that a shape joint's servo gives in hover (`planning.joint_torque`), as far
as it is beyond `SPARED`. Below that, servos change nothing.

Its curvature is taken from first derivatives alone, sharp Cov(grad d) + TILT J^T J + STRAIN K^T K, as Gauss
and Newton do, plus a damping. So it is always positive definite and every step that it gives goes uphill.
"""

from __future__ import annotations

import functools

import casadi as ca
import numpy as np

from skylimb.control.planning.control_torque import face_distances
from skylimb.control.planning.joint_torque import joint_torque_function
from skylimb.robots.model import Robot

SHARP = 60.0
"""How sharply the least margin counts among others, where s is the unit."""

TILT = 100.0
"""What a squared radian of hover tilt costs, where s is the unit."""

STRAIN = 10.0
"""What the square of a servo's strain costs, where s is the unit."""

SPARED = 0.6
"""Share of its torque that a servo may give for nothing."""

DAMPING = 0.5
"""Least curvature, 1/rad^2, where s is the unit."""

PER_RADIAN = 0.2
"""Margin that a radian of room to a joint's end counts as, where s is the unit."""

_ROUNDING = 1e-3
"""How far faces are rounded off, N m."""


@functools.lru_cache(maxsize=16)
def lever(robot: Robot) -> float:
    """Root mean square torque about the centre of gravity for a newton of thrust, nominal posture, m."""
    wrench = robot.wrench_function(robot.nominal_posture(), robot.description.vectoring_start).full()
    return float(np.sqrt(np.mean(np.sum(wrench[3:] ** 2, axis=0))))


@functools.lru_cache(maxsize=16)
def merit_function(robot: Robot) -> ca.Function:
    """(q, psi) -> merit M, margin (N m), tilt (2,) (rad), of any robot of four rotors or more.

    The margin is the least of those of faces and thrusts; negative where hover thrusts are beyond limits.
    """
    q, psi = ca.SX.sym("q", robot.n_joints), ca.SX.sym("psi", robot.n_vectoring)
    flown, all_margins, tilt = _margins(robot, q, psi)
    merit, _ = _merit(all_margins / _unit(robot), tilt, _strain(robot, q, psi))
    return ca.Function("merit", [q, psi], [merit, ca.mmin(flown), tilt], {"cse": True})


@functools.lru_cache(maxsize=16)
def uphill_function(robot: Robot) -> ca.Function:
    """(q, psi) -> M, its gradient (nv,) and its curvature (nv, nv), by the vectoring angles."""
    q, psi = ca.SX.sym("q", robot.n_joints), ca.SX.sym("psi", robot.n_vectoring)
    _, margins, tilt = _margins(robot, q, psi)
    share = margins / _unit(robot)
    strain = _strain(robot, q, psi)
    merit, weights = _merit(share, tilt, strain)
    J, J_tilt, K = ca.jacobian(share, psi), ca.jacobian(tilt, psi), ca.jacobian(strain, psi)
    slope = J.T @ weights
    gradient = slope - TILT * (J_tilt.T @ tilt) - STRAIN * (K.T @ strain)
    spread = J.T @ ca.diag(weights) @ J - slope @ slope.T
    curvature = SHARP * spread + TILT * (J_tilt.T @ J_tilt) + STRAIN * (K.T @ K)
    curvature += DAMPING * ca.SX.eye(robot.n_vectoring)
    return ca.Function("uphill", [q, psi], [merit, gradient, curvature], {"cse": True})


def _unit(robot: Robot) -> float:
    """S, N m."""
    return robot.weight * lever(robot)


def _margins(robot: Robot, q: ca.SX, psi: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Margins of faces and thrusts, these with the vectoring joints', N m, and tilt of the hover, rad."""
    state, (least, most) = robot.model(q, psi), robot.thrust_limits()
    faces = face_distances(state.allocation_C[3:, :], most.tolist(), _ROUNDING)
    room = ca.vertcat(state.hover_thrusts - least, most - state.hover_thrusts) * lever(robot)
    flown = ca.vertcat(faces, room)
    lower, upper = robot.vectoring_limits()
    per_radian = PER_RADIAN * _unit(robot)
    ends = [(psi[i] - lower[i]) * per_radian for i in np.flatnonzero(np.isfinite(lower)).tolist()]
    ends += [(upper[i] - psi[i]) * per_radian for i in np.flatnonzero(np.isfinite(upper)).tolist()]
    return flown, ca.vertcat(flown, *ends), state.R_root_C[:2, 2]


def _strain(robot: Robot, q: ca.SX, psi: ca.SX) -> ca.SX:
    """By how much each shape joint's servo gives more than `SPARED` of its torque, (nq,)."""
    if robot.n_joints == 0:
        return ca.SX.zeros(0)
    given = joint_torque_function(robot)(q, psi) / robot.description.shape_servos.torque_limit
    return ca.fmax(ca.fabs(given) - SPARED, 0.0)


def _merit(share: ca.SX, tilt: ca.SX, strain: ca.SX) -> tuple[ca.SX, ca.SX]:
    """M, and the weight of each margin in its gradient."""
    least = ca.mmin(share)
    shares = ca.exp(-SHARP * (share - least))
    total = ca.sum1(shares)
    merit = least - ca.log(total) / SHARP - 0.5 * TILT * ca.sumsqr(tilt)
    merit -= 0.5 * STRAIN * ca.sumsqr(strain)
    return merit, shares / total
