"""A robot that stands in another posture: its family and its vectoring angles go through that one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.polynomial import chebyshev

from skylimb.errors import DescriptionError, UnreachableError
from skylimb.planning.posture import ReachFamily
from skylimb.planning.posture_rehearsal import rehearse
from skylimb.planning.tip_pose import tip_jacobian
from skylimb.planning.vectoring_criteria import VectoringCriteria
from skylimb.robots.description import PostureFamily
from skylimb.robots.model import Robot

_WIDEST = 0.35
"""How far theta goes to both sides at most, rad."""

_NARROWEST = 0.02
_NODES = 41


def standing_in(robot: Robot, joint_angles: np.ndarray, vectoring_angles: np.ndarray) -> Robot:
    """The same robot with another nominal posture.

    Its family goes along the joints' least move that takes the tip straight away from the centre of gravity,
    q = q_0 + J^+ e_x theta (scaled so that the fastest joint turns by theta), as wide as joint limits and a
    reach that changes one way allow.

    Raises:
        UnreachableError: no such family: the posture is at a joint limit, or the tip cannot move that way.
    """
    q = np.asarray(joint_angles, dtype=float)
    if robot.n_joints == 0:
        return Robot(replace(robot.description, vectoring_start=np.asarray(vectoring_angles, dtype=float)))
    away = np.linalg.pinv(tip_jacobian(robot, q, vectoring_angles), rcond=1e-6)[:, 0]
    fastest = float(np.max(np.abs(away)))
    width = _WIDEST
    while width > _NARROWEST and fastest > 1e-9:
        family = PostureFamily(q, away / fastest, -width, width, 0.0)
        there = replace(robot.description, posture=family, vectoring_start=np.asarray(vectoring_angles))
        try:
            reach = ReachFamily(Robot(there))
        except DescriptionError:  # beyond a limit, or it turns back
            width *= 0.8
            continue
        width = min(-reach.theta_min, reach.theta_max)
        if width > _NARROWEST:
            return Robot(replace(there, posture=replace(family, theta_min=-width, theta_max=width)))
    raise UnreachableError(
        f"'{robot.name}' cannot move its tip to and fro at joint angles {np.round(q, 3).tolist()} rad within "
        "its joint limits"
    )


def vectoring_through(robot: Robot, vectoring_angles: np.ndarray, criteria: VectoringCriteria) -> np.ndarray:
    """Chebyshev coefficients (nv, degree + 1) of psi over the family: psi_0 in its nominal posture.

    To both sides the angles move as a plan in flight moves them (`planning.vectoring_step`).
    """
    posture = robot.description.posture
    low, high = criteria.span(robot)
    sides = [np.linspace(posture.theta_nominal, end, _NODES) for end in (low, high)]
    psi = [
        rehearse(robot, posture.offset + posture.slope * side[:, None], vectoring_angles).vectoring_angles
        for side in sides
    ]
    moves = [angles - angles[0] for angles in psi]
    theta = np.concatenate([sides[0][::-1], sides[1][1:]])
    values = vectoring_angles + np.vstack([moves[0][::-1], moves[1][1:]])
    x = (2.0 * theta - (low + high)) / (high - low)
    fitted = chebyshev.chebfit(x, values, criteria.degree)
    # The nominal posture is met exactly.
    middle = chebyshev.chebval((2.0 * posture.theta_nominal - (low + high)) / (high - low), fitted)
    fitted[0] += vectoring_angles - middle
    return fitted.T
