"""FCTmin of numbers: the distance of no torque from the nearest face of all torques."""

from typing import Any

import numpy as np

from skylimb.robots import Robot
from skylimb.studies.planning.zonotope import zonotope


def guaranteed_torque(allocation: np.ndarray, thrust_max: Any) -> float:
    """Torque about every axis, N m, of an allocation matrix (6, n) or its torque rows (3, n), m."""
    rows = np.asarray(allocation, dtype=float)[-3:]
    most = np.broadcast_to(np.asarray(thrust_max, dtype=float), rows.shape[1:])
    return max(zonotope(rows, np.zeros_like(most), most).margin(np.zeros(3)), 0.0)


def torque_along(robot: Robot, table: Any, thetas: np.ndarray) -> np.ndarray:
    """FCTmin (N m) along a table of vectoring angles."""
    most = [rotor.thrust_max for rotor in robot.description.rotors]
    return np.array([guaranteed_torque(state.allocation_C, most) for state in states(robot, table, thetas)])


def tilt_along(robot: Robot, table: Any, thetas: np.ndarray) -> np.ndarray:
    """Tilt of the hover (rad) along a table of vectoring angles."""
    cosines = [state.R_root_C[2, 2] for state in states(robot, table, thetas)]
    return np.arccos(np.clip(cosines, -1.0, 1.0))


def states(robot: Robot, table: Any, thetas: np.ndarray) -> list[Any]:
    posture = robot.description.posture
    return [
        robot.at(posture.offset + posture.slope * theta, table.angles(theta)) for theta in np.ravel(thetas)
    ]
