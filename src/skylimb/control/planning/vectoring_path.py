"""Vectoring angles along any path of postures, knot by knot from where they are.

At every knot the guaranteed control torque is maximised again, without hover tilt, within the joint limits
and within a small step of the angles before, as the laboratory's own planner does in flight. It cannot see a
singular posture coming: use the table of the posture family (`planning.vectoring`) where that family is all
that is flown.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from skylimb.base.errors import AllocationError
from skylimb.control.planning.control_torque import face_distances
from skylimb.control.planning.nlp import ipopt, search
from skylimb.robots.model import Robot

STEP = 0.2
"""Greatest change of a vectoring angle between two knots, rad."""

TILT = 0.01
"""Greatest hover tilt in roll and in pitch, rad."""

_SMOOTHING = 2.0
"""Guaranteed torque given up for a smaller change, N m per rad^2."""

_ROUNDING = 1e-4


def vectoring_path(robot: Robot, postures: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Vectoring angles (k, nv) for joint angles `postures` (k, nq), beginning near `start` (nv,), all rad.

    Raises:
        AllocationError: no vectoring angles within a step of the last hover without tilt at some posture.
    """
    nq, nv = robot.n_joints, robot.n_vectoring
    if nv == 0:
        return np.zeros((len(postures), 0))
    lower, upper = robot.vectoring_limits()
    q, psi, last, t = ca.SX.sym("q", nq), ca.SX.sym("psi", nv), ca.SX.sym("last", nv), ca.SX.sym("t")
    model, (least, most) = robot.model(q, psi), robot.thrust_limits()
    faces = face_distances(model.allocation_C[3:, :], most.tolist(), _ROUNDING)
    problem = {
        "x": ca.vertcat(psi, t),
        "p": ca.vertcat(q, last),
        "f": -t + _SMOOTHING * ca.sumsqr(psi - last),
        "g": ca.vertcat(faces - t, model.R_root_C[:2, 2], model.hover_thrusts),
    }
    solver = ipopt(problem, 200)
    low = [0.0] * faces.shape[0] + [-TILT] * 2 + least.tolist()
    high = [np.inf] * faces.shape[0] + [TILT] * 2 + most.tolist()
    now, torque, found = np.asarray(start, dtype=float), 1.0, []
    for posture in postures:
        solution = search(
            solver,
            [*now, torque],
            p=[*posture, *now],
            lbx=[*np.maximum(now - STEP, lower), -np.inf],
            ubx=[*np.minimum(now + STEP, upper), np.inf],
            lbg=low,
            ubg=high,
        )
        if solution is None:
            raise AllocationError(
                f"no vectoring angles within {STEP:g} rad of {np.round(now, 3).tolist()} let {robot.name} "
                f"hover level at joint angles {np.round(posture, 3).tolist()} rad"
            )
        now, torque = solution[1][:nv], float(solution[1][nv])
        found.append(now)
    return np.array(found)
