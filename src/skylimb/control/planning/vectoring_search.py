"""Search for vectoring angles psi(theta): most guaranteed control torque within criteria, one smooth branch.

Optimising psi anew at every theta jumps between branches (near theta = 0.3 for the paper's robot, with slopes
of 8 rad/rad). So psi(theta) is one low-degree polynomial for each joint, and a single program finds all
coefficients:

    maximise   mean over theta of FCTmin  -  smoothing * mean of |dpsi/dtheta|^2
    subject to |hover tilt| <= tilt, |dpsi_i/dtheta| <= slope, thrust_min <= hover thrusts <= thrust_max
               at nodes spread over theta, and for contact |X_xy|, |X_xz| <= leak, X_yy >= sideways;
               psi within the vectoring joints' limits where these have any, and the shape joints' torques
               within a share of their servos' where that counts.

The program has many local optima. It starts from the optima of single postures, first with few coefficients,
and the best few of those are refined with all of them. Every start is fixed, so the result is always the
same.
"""

from __future__ import annotations

import math
from typing import Any

import casadi as ca
import numpy as np
from numpy.polynomial import chebyshev

from skylimb.base.errors import AllocationError
from skylimb.base.rotations import wrapped
from skylimb.control.planning.control_torque import face_distances
from skylimb.control.planning.joint_torque import joint_torque_function
from skylimb.control.planning.lateral_effort import lateral_effort
from skylimb.control.planning.nlp import distinct, ipopt, searches
from skylimb.control.planning.tip_force import tip_force_map
from skylimb.control.planning.vectoring_criteria import TORQUE, VectoringCriteria
from skylimb.control.planning.vectoring_program import PathProgram, Posture, turns_freely
from skylimb.robots import Robot
from skylimb.robots.starts import vectoring_starts

VERSION = 1
"""Counts up when the search changes, so that tables found by an older one are not used."""

_ROUNDING = 1e-4
_COARSE_DEGREE = 3
_REFINED = 3
_TRIES = 16
_SAME = 0.1


class NoPathError(AllocationError):
    """No continuous path of vectoring angles keeps the criteria over their range."""


def no_path(robot: Robot, criteria: VectoringCriteria) -> NoPathError:
    """What to raise where a robot has no such path."""
    low, high = criteria.span(robot)
    return NoPathError(
        f"no continuous vectoring angles of '{robot.name}' {criteria.kept} from theta = {low:g} to "
        f"{high:g} rad"
    )


def search_vectoring(robot: Robot, criteria: VectoringCriteria = TORQUE) -> np.ndarray:
    """Chebyshev coefficients (n_vectoring, degree + 1) of psi over the criteria's range of theta, rad.

    Raises:
        AllocationError: no continuous path of vectoring angles keeps the criteria over the range.
    """
    if robot.n_vectoring == 0:
        return np.zeros((0, criteria.degree + 1))
    posture = posture_function(robot, criteria)
    coarse = PathProgram(posture, criteria, _COARSE_DEGREE, 9, 80)
    paths = [coarse.solve(start) for start in _starts(robot, posture)]
    ranked = sorted((path for path in paths if path is not None), key=lambda path: path[0], reverse=True)
    apart = distinct(ranked, lambda path: path[1][:, 0], _SAME)
    fine = PathProgram(posture, criteria, criteria.degree, 24, 150)
    refined = [fine.solve(coefficients) for _, coefficients in apart[:_REFINED]]
    best = max((path for path in refined if path is not None), key=lambda path: path[0], default=None)
    if best is None:
        raise no_path(robot, criteria)
    return _near_zero(robot, posture.span, best[1])


def evaluate(coefficients: np.ndarray, low: float, high: float, theta: Any, order: int = 0) -> np.ndarray:
    """The polynomials (or a derivative by theta of some order) at an array of theta: (..., nv)."""
    x = (2.0 * np.asarray(theta, dtype=float) - (low + high)) / (high - low)
    series = chebyshev.chebder(coefficients, order, axis=1) * (2.0 / (high - low)) ** order
    return np.moveaxis(chebyshev.chebval(x, series.T), 0, -1)


def _near_zero(robot: Robot, span: tuple[float, float], coefficients: np.ndarray) -> np.ndarray:
    """The same path, whole turns away: at the nominal posture each joint is within half a turn of zero.

    A joint with limits stays where it is.
    """
    nominal = evaluate(coefficients, *span, robot.description.posture.theta_nominal)
    moved = coefficients.copy()
    moved[:, 0] += np.where(turns_freely(*robot.vectoring_limits()), wrapped(nominal) - nominal, 0.0)
    return moved


def posture_function(robot: Robot, criteria: VectoringCriteria) -> Posture:
    """What the search sees of any posture of the robot's family: face distances, and what is bounded."""
    family = robot.description.posture
    theta, psi = ca.SX.sym("theta"), ca.SX.sym("psi", robot.n_vectoring)
    q = ca.DM(family.offset) + ca.DM(family.slope) * theta
    faces, bounded, low, high = bounded_by(robot, criteria, q, psi)
    function = ca.Function("posture", [theta, psi], [faces, bounded])
    low, high = [0.0] * faces.shape[0] + low, [np.inf] * faces.shape[0] + high
    return Posture(function, low, high, criteria.span(robot), robot.vectoring_limits())


def bounded_by(
    robot: Robot, criteria: VectoringCriteria, q: ca.SX, psi: ca.SX
) -> tuple[ca.SX, ca.SX, list[float], list[float]]:
    """Face distances of a posture, N m, and what the criteria bound in it: values, least, greatest."""
    state, (least, most) = robot.model(q, psi), robot.thrust_limits()
    faces = face_distances(state.allocation_C[3:, :], most.tolist(), _ROUNDING)
    margins = criteria.thrust_margin * (most - least)
    tilt = state.R_root_C[:2, 2]
    bounded = [tilt, state.hover_thrusts]
    low = [-criteria.tilt] * 2 + (least + margins).tolist()
    high = [criteria.tilt] * 2 + (most - margins).tolist()
    if criteria.about_contact:
        X = tip_force_map(state)
        bounded += [ca.sumsqr(tilt), X[0, 1], X[0, 2], X[1, 1]]
        low += [0.0, -criteria.leak, -criteria.leak, criteria.sideways]
        high += [criteria.tilt**2, criteria.leak, criteria.leak, np.inf]
    if math.isfinite(criteria.effort):
        bounded += [lateral_effort(robot, q, psi)]
        low += [0.0] * 2
        high += [criteria.effort] * 2
    if math.isfinite(criteria.servos):
        bounded += [joint_torque_function(robot)(q, psi) / robot.description.shape_servos.torque_limit]
        low += [-criteria.servos] * robot.n_joints
        high += [criteria.servos] * robot.n_joints
    return faces, ca.vertcat(*bounded), low, high


def _starts(robot: Robot, posture: Posture) -> list[np.ndarray]:
    """Distinct local optima of psi at single postures, best first at each."""
    n = robot.n_vectoring
    psi, t, theta = ca.SX.sym("psi", n), ca.SX.sym("t"), ca.SX.sym("theta")
    faces, bounded = posture.function(theta, psi)
    problem = {"x": ca.vertcat(psi, t), "p": theta, "f": -t, "g": ca.vertcat(faces - t, bounded)}
    solver = ipopt(problem, 100)
    tries = vectoring_starts(robot, robot.description.vectoring_start, _TRIES)
    lower, upper = posture.limits
    free = turns_freely(lower, upper)
    bounds = {} if free.all() else {"lbx": [*lower, -np.inf], "ubx": [*upper, np.inf]}
    begun = [[*start, 1.0] for start in tries]
    # Without joints that bend, all postures are the first one, and so are their optima.
    bends = bool(np.any(robot.description.posture.slope))
    found = [
        np.where(free, wrapped(x[:n]), x[:n])
        for angle in np.linspace(*posture.span, 4 if bends else 1)
        for _, x in searches(solver, begun, p=angle, lbg=posture.low, ubg=posture.high, **bounds)
    ]
    return distinct(found, lambda angles: angles, _SAME)
