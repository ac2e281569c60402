"""How hard a robot that holds still can push with its tip.

At rest the rotors carry the weight and the push, and turn nothing:

    R Q_t lambda = m g z + p,        Q_r lambda = r x R^T p,

with p the push of the tip on the surface, r the tip from the centre of gravity, R the attitude of {C}. Free
are tilt, thrusts and small moves of the vectoring angles, each within its limits; the heading is held. Tilt
is the angle of {C} from the vertical. The greatest p along a direction is a small nonlinear programme, solved
from an upright body and from one that leans either way. What has no solution here cannot be flown by any
control law in that posture. What has one may still fail in flight, where thrust is needed for more than rest.
"""

from __future__ import annotations

import functools

import casadi as ca
import numpy as np

from skylimb.robots.model import Robot
from skylimb.spatial import cross, rot_x, rot_y, rot_z

_EXACT = 1e-6
"""A solution leaves less than this share of the weight over, as a force and as a torque at 1 m."""

_UPRIGHT = 1e-6
"""Tilt, rad, that stands for none: four rotors hold a wrench of six only with some."""

_LYING = 1.5
"""Tilt, rad, beyond which no rest is sought."""

_LEANS = (0.0, 0.3, -0.3)
"""Leans into the push with which the search begins, rad; with tilted rotors it may rest leaned away."""

_QUIET = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": False, "error_on_fail": False}


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
        tilt: of {C}, the greatest, rad.
        moves: how far each vectoring angle may move from psi, rad.
    """
    size = float(np.linalg.norm(push))
    direction = np.asarray(push, dtype=float) / size if size > 0.0 else np.array([0.0, 0.0, 1.0])
    most = _farthest(robot, (joint_angles, vectoring_angles, direction), size, tilt, moves)
    return most == size


def greatest_push(
    robot: Robot,
    joint_angles: np.ndarray,
    vectoring_angles: np.ndarray,
    direction: np.ndarray,
    most: float,
    tilt: float,
    moves: float = 0.0,
) -> float:
    """The greatest push along a direction up to `most` N with which the robot can rest, N; 0 without any.

    Other arguments are those of `can_push`; `direction` is a unit vector in the same frame.
    """
    return _farthest(robot, (joint_angles, vectoring_angles, direction), most, tilt, moves) or 0.0


def _farthest(
    robot: Robot, given: tuple[np.ndarray, np.ndarray, np.ndarray], most: float, tilt: float, moves: float
) -> float | None:
    """The greatest push, N, at joint and vectoring angles along a direction; None without any rest.

    It is `most` itself where the programme comes that near to it that only rounding is left.
    """
    q, psi, direction = (np.asarray(value, dtype=float) for value in given)
    rotors, still = robot.description.rotors, np.zeros(robot.n_vectoring)
    tilt = min(max(tilt, _UPRIGHT), _LYING)
    low = [-tilt, -tilt, *(rotor.thrust_min for rotor in rotors), *(still - moves), 0.0]
    high = [tilt, tilt, *(rotor.thrust_max for rotor in rotors), *(still + moves), most]
    hover, side = robot.at(q, psi).hover_thrusts, np.array([-direction[1], direction[0]])
    found: list[float] = []
    for lean in _LEANS:
        begin = np.concatenate([np.clip(lean, -0.5 * tilt, 0.5 * tilt) * side, hover, still, [0.0]])
        rest = _programme(robot)(
            x0=begin,
            p=np.concatenate([q, psi, direction, [tilt]]),
            lbx=low,
            ubx=high,
            lbg=[*[0.0] * 6, -np.inf],
            ubg=[*[0.0] * 6, 1.0 if tilt > _UPRIGHT else np.inf],
        )
        if float(np.abs(rest["g"].full()[:6]).max()) < _EXACT:
            push = max(float(rest["x"][-1]), 0.0)
            if push >= (1.0 - _EXACT) * most:
                return most
            found.append(push)
    return max(found, default=None)


@functools.lru_cache(maxsize=16)
def _programme(robot: Robot) -> ca.Function:
    """The greatest push t along d: x is that of `statics_function` and t; p is q, psi, d, greatest tilt."""
    weight = robot.weight
    x, t = ca.SX.sym("x", 2 + robot.n_rotors + robot.n_vectoring), ca.SX.sym("t")
    q, psi, d = ca.SX.sym("q", robot.n_joints), ca.SX.sym("psi", robot.n_vectoring), ca.SX.sym("d", 3)
    left = statics_function(robot)(x, q, psi, t * d) / weight
    tilt, roll, pitch = ca.SX.sym("tilt"), x[0], x[1]
    # (sin of the angle from the vertical over that of the greatest)^2
    leant = (ca.sin(roll) ** 2 + (ca.cos(roll) * ca.sin(pitch)) ** 2) / ca.sin(tilt) ** 2
    problem = {
        "x": ca.vertcat(x, t),
        "p": ca.vertcat(q, psi, d, tilt),
        "f": -t / weight,
        "g": ca.vertcat(left, leant),
    }
    return ca.nlpsol("push", "ipopt", problem, _QUIET)


@functools.lru_cache(maxsize=16)
def statics_function(robot: Robot) -> ca.Function:
    """(x, q, psi, p) -> what is left over of force (N) and torque (N m), (6,).

    x is roll and pitch of {C}, the thrusts, and the moves of the vectoring angles.
    """
    q, psi, p = ca.SX.sym("q", robot.n_joints), ca.SX.sym("psi", robot.n_vectoring), ca.SX.sym("p", 3)
    x = ca.SX.sym("x", 2 + robot.n_rotors + robot.n_vectoring)
    thrusts, moves = x[2 : 2 + robot.n_rotors], x[2 + robot.n_rotors :]
    state = robot.model(q, psi + moves)
    attitude = ca.SX(rot_z(-state.tip_heading)) @ ca.SX(rot_y(x[1])) @ ca.SX(rot_x(x[0]))
    weight = ca.vertcat(0.0, 0.0, robot.weight)
    force = state.allocation_C[:3, :] @ thrusts - attitude.T @ (weight + p)
    torque = state.allocation_C[3:, :] @ thrusts - cross(state.tip_C, attitude.T @ p)
    return ca.Function("left", [x, q, psi, p], [ca.cse(ca.vertcat(force, torque))])
