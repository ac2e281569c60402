"""Whether a robot can hold still while it pushes with a given force at its tip.

At rest the rotors carry the weight and the push, and turn nothing:

    R Q_t lambda = m g z + p,        Q_r lambda = r x R^T p,

with p the push of the tip on the surface, r the tip from the centre of gravity, R the attitude of {C}. Free
are tilt, thrusts and small moves of the vectoring angles, each within its limits; the heading is held. What
has no solution here cannot be flown by any control law in that posture. What has one may still fail in
flight, where thrust is needed for more than rest.
"""

from __future__ import annotations

import functools

import casadi as ca
import numpy as np

from skylimb.robots.model import GRAVITY, Robot
from skylimb.spatial import cross, rot_x, rot_y, rot_z

_EXACT = 1e-4
"""A solution leaves less than this share of the weight over."""

_UPRIGHT = 1e-6
"""Tilt, rad, that stands for none: the solver wants room on both sides."""

_FINE = 0.05
"""Width, N, to which the greatest push is sought."""


def can_push(
    robot: Robot,
    joint_angles: np.ndarray,
    vectoring_angles: np.ndarray,
    push: np.ndarray,
    tilt: float,
    moves: float = 0.0,
) -> bool:
    """Whether the robot can rest while its tip pushes.

    Args:
        robot: whose rotors have limits.
        joint_angles: q, rad, (nq,).
        vectoring_angles: psi, rad, (nv,).
        push: p in the level frame whose x axis is the tip link's, N, (3,).
        tilt: greatest roll and greatest pitch of {C}, rad.
        moves: how far each vectoring angle may move from psi, rad.
    """
    q, psi, p = (np.asarray(value, dtype=float) for value in (joint_angles, vectoring_angles, push))
    weight = robot.mass * GRAVITY
    tilted = np.array([-np.arctan(p[1] / weight), np.arctan(p[0] / weight)])
    hover = robot.at(q, psi).hover_thrusts
    guess = np.concatenate([tilted, hover])
    nearest, rests = _nearest_to_rest(robot, (q, psi, p), guess, tilt, 0.0)
    # The search is a local one. A robot whose rotors push to the side may rest less tilted, and once the tilt
    # is given the thrusts are a linear problem.
    for share in (1.0, 0.5, 0.0):
        if rests:
            return True
        start = _with_best_thrusts(robot, (q, psi, p), np.clip(share * tilted, -tilt, tilt))
        _, rests = _nearest_to_rest(robot, (q, psi, p), start, tilt, 0.0)
    if rests or moves <= 0.0:
        return rests
    # It begins where the angles as they are come nearest, and in the hover.
    still = np.zeros(robot.n_vectoring)
    return any(
        _nearest_to_rest(robot, (q, psi, p), np.append(start, still), tilt, moves)[1]
        for start in (nearest, guess)
    )


def _with_best_thrusts(
    robot: Robot, given: tuple[np.ndarray, np.ndarray, np.ndarray], tilted: np.ndarray
) -> np.ndarray:
    """Roll, pitch, and the thrusts within their limits that leave least over at them."""
    from scipy.optimize import lsq_linear

    residual, slopes = _statics(robot)
    rotors = robot.description.rotors
    x = np.concatenate([tilted, np.zeros(robot.n_rotors + robot.n_vectoring)])
    matrix = slopes(x, *given).full()[:, 2 : 2 + robot.n_rotors]
    bounds = [rotor.thrust_min for rotor in rotors], [rotor.thrust_max for rotor in rotors]
    return np.append(tilted, lsq_linear(matrix, -residual(x, *given).full().ravel(), bounds).x)


def _nearest_to_rest(
    robot: Robot,
    given: tuple[np.ndarray, np.ndarray, np.ndarray],
    guess: np.ndarray,
    tilt: float,
    moves: float,
) -> tuple[np.ndarray, bool]:
    """Roll, pitch, thrusts and perhaps moves that leave least over, and whether they leave nothing."""
    from scipy.optimize import least_squares  # slow to import, and few flights need it

    residual, slopes = _statics(robot)
    rotors, n, weight = robot.description.rotors, len(guess), robot.mass * GRAVITY
    tilt = max(tilt, _UPRIGHT)
    reach = np.array([tilt, tilt, *(rotor.thrust_max for rotor in rotors), *[moves] * robot.n_vectoring])[:n]
    low = np.array([-tilt, -tilt, *(rotor.thrust_min for rotor in rotors), *[-moves] * robot.n_vectoring])[:n]
    rest = np.zeros(2 + robot.n_rotors + robot.n_vectoring - n)
    margin = 1e-3 * (reach - low)
    found = least_squares(
        lambda x: residual(np.append(x, rest), *given).full().ravel() / weight,
        np.clip(guess, low + margin, reach - margin),
        jac=lambda x: slopes(np.append(x, rest), *given).full()[:, :n] / weight,  # pyright: ignore[reportArgumentType]
        bounds=(low, reach),
        x_scale=reach - low,  # pyright: ignore[reportArgumentType]
        xtol=1e-12,
        ftol=1e-12,
        gtol=1e-12,
        max_nfev=100,
    )
    return found.x, float(np.linalg.norm(found.fun)) < _EXACT


def greatest_push(
    robot: Robot,
    joint_angles: np.ndarray,
    vectoring_angles: np.ndarray,
    direction: np.ndarray,
    most: float,
    tilt: float,
    moves: float = 0.0,
) -> float:
    """The greatest push along a direction up to `most` N with which the robot can rest, N.

    Other arguments are those of `can_push`; `direction` is a unit vector in the same frame.
    """
    low, high = 0.0, most
    while high - low > _FINE:
        middle = 0.5 * (low + high)
        if can_push(robot, joint_angles, vectoring_angles, middle * direction, tilt, moves):
            low = middle
        else:
            high = middle
    return low


def statics_function(robot: Robot) -> ca.Function:
    """(x, q, psi, p) -> what is left over of force (N) and torque (N m), (6,); see `_statics`."""
    return _statics(robot)[0]


@functools.lru_cache(maxsize=16)
def _statics(robot: Robot) -> tuple[ca.Function, ca.Function]:
    """(x, q, psi, p) -> what is left over of force (N) and torque (N m), (6,), and its derivative by x.

    x is roll and pitch of {C}, the thrusts, and the moves of the vectoring angles.
    """
    q, psi, p = ca.SX.sym("q", robot.n_joints), ca.SX.sym("psi", robot.n_vectoring), ca.SX.sym("p", 3)
    x = ca.SX.sym("x", 2 + robot.n_rotors + robot.n_vectoring)
    thrusts, moves = x[2 : 2 + robot.n_rotors], x[2 + robot.n_rotors :]
    state = robot.model(q, psi + moves)
    attitude = ca.SX(rot_z(-state.tip_heading)) @ ca.SX(rot_y(x[1])) @ ca.SX(rot_x(x[0]))
    weight = ca.vertcat(0.0, 0.0, robot.mass * GRAVITY)
    force = state.allocation_C[:3, :] @ thrusts - attitude.T @ (weight + p)
    torque = state.allocation_C[3:, :] @ thrusts - cross(state.tip_C, attitude.T @ p)
    left = ca.cse(ca.vertcat(force, torque))
    return ca.Function("left", [x, q, psi, p], [left]), ca.Function(
        "slopes", [x, q, psi, p], [ca.jacobian(left, x)]
    )
