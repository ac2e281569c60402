"""The nearest posture that leaves a margin in hover, for one that does not."""

from __future__ import annotations

import functools
import math

import casadi as ca
import numpy as np

from skylimb.control.planning.hover_margins import hover_margins_function
from skylimb.control.planning.nlp import ipopt, searches
from skylimb.robots.model import Robot
from skylimb.robots.starts import vectoring_starts

_LEVEL = 0.02
"""Tilt of the hover in a posture that is found, in its two parts, rad."""

_STARTS = 4
"""Sets of vectoring angles that a search begins with."""

_SPARE = 0.02
"""How much more than the least margin a posture that is found leaves, N m."""


def nearest_posture(
    robot: Robot, joint_angles: np.ndarray, vectoring_angles: np.ndarray, least: float
) -> np.ndarray | None:
    """The posture nearest to one that leaves a margin (N m) in level hover, q (nq,), rad; None if none is.

    Joint and vectoring angles are free within their limits. Joints are given as commanded, margins are those
    where the servos hold them. A local search from the posture and from the
    nominal one, each with several vectoring angles; the nearest of what they find.
    """
    if robot.n_joints == 0:
        return None
    solver, lower, upper, count = _program(robot)
    level = _LEVEL if robot.n_vectoring else math.inf
    low = [least + _SPARE] * count + [-level] * 2 + [-1.0] * robot.n_joints
    high = [math.inf] * count + [level] * 2 + [1.0] * robot.n_joints
    wanted = np.asarray(joint_angles, dtype=float)
    starts = [
        [*q, *psi]
        for psi in vectoring_starts(robot, vectoring_angles, _STARTS)
        for q in (wanted, robot.nominal_posture())
    ]
    found = searches(solver, starts, p=wanted, lbx=lower, ubx=upper, lbg=low, ubg=high)
    return found[0][1][: robot.n_joints] if found else None


@functools.lru_cache(maxsize=16)
def _program(robot: Robot) -> tuple[ca.Function, np.ndarray, np.ndarray, int]:
    """The program over (q, psi), bounds of these, and how many margins it keeps."""
    nq, nv = robot.n_joints, robot.n_vectoring
    x, wanted = ca.SX.sym("x", nq + nv), ca.SX.sym("wanted", nq)
    margins, tilt, shares = hover_margins_function(robot)(x[:nq], x[nq:])
    kept = ca.vertcat(margins, tilt, shares)
    problem = {"x": x, "p": wanted, "f": ca.sumsqr(x[:nq] - wanted), "g": kept}
    lower, upper = (
        np.concatenate(pair) for pair in zip(robot.joint_limits(), robot.vectoring_limits(), strict=True)
    )
    return ipopt(problem, 100), np.maximum(lower, -1e9), np.minimum(upper, 1e9), int(margins.shape[0])
