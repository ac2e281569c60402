"""FCTmin: the torque that the rotors can give in every direction, whatever the direction.

The torques that thrusts 0 <= lambda_i <= lambda_max,i can give fill a zonotope, a solid bounded by
parallelograms. Each face is spanned by the torque directions of two rotors; the rotors on its outer side push
fully, the others not at all. The guaranteed control torque is the distance from zero torque to the nearest
face (`feasible_wrench.fct_min`). Here the faces are expressions, for the searches for vectoring angles.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import casadi as ca

_PARALLEL = 1e-12


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
