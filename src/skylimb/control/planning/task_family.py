"""A robot that stands in another posture: its family and its vectoring angles go through that one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from skylimb.base.errors import UnreachableError
from skylimb.control.planning.posture import widest_family
from skylimb.control.planning.task import Task, TaskPosture, judged_posture
from skylimb.control.planning.tip_pose import tip_jacobian
from skylimb.control.planning.vectoring_criteria import VectoringCriteria
from skylimb.control.planning.vectoring_program import PathProgram
from skylimb.control.planning.vectoring_search import evaluate, posture_function
from skylimb.robots.equilibrium_results import Limit, NotHeld
from skylimb.robots.model import Robot

_COARSE = 3
"""Degree of the polynomials that are found first."""


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
    if fastest > 1e-9:
        there = Robot(replace(robot.description, vectoring_start=np.asarray(vectoring_angles)))
        family = widest_family(there, q, away / fastest, 0.0)
        if family is not None:
            return Robot(replace(there.description, posture=family))
    raise UnreachableError(
        f"'{robot.name}' cannot move its tip to and fro at joint angles {np.round(q, 3).tolist()} rad within "
        "its joint limits"
    )


def settled_in(
    robot: Robot, task: Task, planned: TaskPosture
) -> tuple[TaskPosture, Robot, np.ndarray] | NotHeld | None:
    """A planned posture as it can be flown: as the angles all along its family leave it.

    The program that finds the tables of robots that ship begins at the planned vectoring angles: what the
    criteria bound is kept all along the family, not only in the posture itself. So the angles there become
    others, and the margin less.

    Returns:
        The posture with those angles, the robot that stands in it, and Chebyshev coefficients
        (nv, degree + 1) of psi over its family. `NotHeld` where these angles do not hold the pushes with
        anything left; None where no path of that branch keeps the criteria, or the tip cannot move to and
        fro.
    """
    try:
        there = standing_in(robot, planned.joint_angles, planned.vectoring_angles)
    except UnreachableError:
        return None
    coefficients = _vectoring_along(there, planned.vectoring_angles, task.criteria)
    if coefficients is None:
        return None
    psi = evaluate(coefficients, *task.criteria.span(there), there.description.posture.theta_nominal)
    judged = judged_posture(robot, task, planned.joint_angles, psi, planned.heading)
    if isinstance(judged, NotHeld):
        return judged
    if judged.margin <= 0.0:
        return NotHeld(Limit("margin", "", 0.0, "N m"), 0.0, greatest=task.force)
    return judged, there, coefficients


def _vectoring_along(robot: Robot, start: np.ndarray, criteria: VectoringCriteria) -> np.ndarray | None:
    if robot.n_vectoring == 0:
        return np.zeros((0, criteria.degree + 1))
    posture, found = posture_function(robot, criteria), (0.0, start)
    for degree, nodes in ((_COARSE, 9), (criteria.degree, 24)):
        found = PathProgram(posture, criteria, degree, nodes, 150).solve(found[1])
        if found is None:
            return None
    return found[1]
