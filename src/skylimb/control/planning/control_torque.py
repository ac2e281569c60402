"""FCTmin: the torque that the rotors can give in every direction, whatever the direction.

The torques that thrusts 0 <= lambda_i <= lambda_max,i can give fill a zonotope, a solid bounded by
parallelograms. Each face is spanned by the torque directions of two rotors; the rotors on its outer side push
fully, the others not at all. The guaranteed control torque is the distance from zero torque to the nearest
face.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import casadi as ca
import numpy as np

from skylimb.base.errors import AllocationError

_PARALLEL = 1e-12


def guaranteed_control_torque(
    allocation: np.ndarray, thrust_max: float | Sequence[float] | np.ndarray
) -> float:
    """The greatest torque that can be given about every axis, in N m.

    Args:
        allocation: (6, n) allocation matrix, force rows first, or its (3, n) torque rows, m.
        thrust_max: greatest thrust, of all rotors or of each (n,), N. The least thrust counts as zero.

    Raises:
        AllocationError: the matrix does not have 3 or 6 rows, or a limit is not positive.
    """
    matrix = np.asarray(allocation, dtype=float)
    if matrix.ndim != 2 or matrix.shape[0] not in (3, 6):
        raise AllocationError(
            f"an allocation matrix of shape {matrix.shape} has no torque rows; it is (6, n) or (3, n)"
        )
    torques = matrix[-3:] * np.broadcast_to(np.asarray(thrust_max, dtype=float), matrix.shape[1:])
    if not np.all(np.isfinite(torques)) or np.any(np.asarray(thrust_max) <= 0.0):
        raise AllocationError(
            f"thrust_max = {thrust_max} N must be positive and the allocation matrix finite"
        )
    return _nearest(torques)[0]


def nearest_face(allocation: np.ndarray, thrust_max: float | Sequence[float] | np.ndarray) -> np.ndarray:
    """The axis about which the guaranteed torque is least: unit normal of the nearest face, (3,).

    Arguments are those of `guaranteed_control_torque`, and not checked again.
    """
    torques = np.asarray(allocation, dtype=float)[-3:] * thrust_max
    return _nearest(torques)[1]


def _nearest(torques: np.ndarray) -> tuple[float, np.ndarray]:
    """Distance of the nearest face from no torque, and its unit normal; of torques (3, n), N m."""
    nearest, axis = np.inf, np.zeros(3)
    for i, j in itertools.combinations(range(torques.shape[1]), 2):
        normal = np.cross(torques[:, i], torques[:, j])
        size = np.linalg.norm(normal)
        if size <= _PARALLEL * np.linalg.norm(torques[:, i]) * np.linalg.norm(torques[:, j]):
            continue  # parallel torques span no face
        heights = normal @ torques / size
        distance = min(np.sum(heights[heights > 0.0]), -np.sum(heights[heights < 0.0]))
        if distance < nearest:
            nearest, axis = float(distance), normal / size
    return (nearest, axis) if np.isfinite(nearest) else (0.0, axis)


def face_distances(torque_rows: Any, thrust_max: Sequence[float], rounding: float) -> Any:
    """Distance of each face of the zonotope from zero torque, in CasADi expressions, for an optimisation.

    max(0, x) is rounded off, (x + sqrt(x^2 + rounding^2)) / 2, so that it has a derivative.

    Args:
        torque_rows: 3 x n expression, m.
        thrust_max: greatest thrust of each rotor, N.
        rounding: in N m; each distance is too large by at most (n - 2) / 2 times this.

    Returns:
        n (n - 1) x 1, N m.
    """
    n = len(thrust_max)
    torques = [torque_rows[:, k] * thrust_max[k] for k in range(n)]
    distances = []
    for i, j in itertools.combinations(range(n), 2):
        normal = ca.cross(torques[i], torques[j])
        normal = normal / ca.sqrt(ca.sumsqr(normal) + _PARALLEL)
        heights = [ca.dot(normal, torques[k]) for k in range(n) if k not in (i, j)]
        total = sum(heights)
        rounded = sum(ca.sqrt(height * height + rounding**2) for height in heights)
        distances += [0.5 * (rounded + total), 0.5 * (rounded - total)]
    return ca.vertcat(*distances)
