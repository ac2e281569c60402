"""The task frame: six directions at the tip in which a law may be stiff, soft, or push.

Its axes are the contact axis a, the sliding axis u and v = a x u. Matrices of a law stand in it: a symmetric
matrix is three entries of its diagonal and three beside it. A wrench that acts on the tip is the one at the
centre of gravity with the force's lever taken off.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from skylimb.base.keys import Vector3, refused
from skylimb.control.estimation.records import Estimate, Wrench
from skylimb.control.missions.reference import Reference
from skylimb.symbolic import Array, cross, matrix, right_inverse

COUPLING: Vector3 = (0.0, 0.0, 0.0)
"""No entries beside the diagonal."""


def task_axes(reference: Reference) -> Array:
    """R_WT, (3, 3): contact axis, sliding axis and their cross product as columns."""
    a, u = reference.contact_axis, reference.sliding_axis
    v = cross(a, u)
    return matrix([[a[i], u[i], v[i]] for i in range(3)])


def tip_wrench(estimate: Estimate, R_WT: Array) -> Wrench:
    """The estimated wrench on the robot at its tip: force, N, and torque, N m, both in the axes of the task.

    The lever is the model's in the measured attitude, in which the observer works, and not the corrected arm:
    a force of 3 N on an arm of 1.1 m that is turned by one degree would read as a torque of 0.06 N m.
    """
    wrench, body = estimate.wrench, estimate.body
    lever = body.R_WC @ body.model.tip_C
    torque = body.R_WC @ wrench.torque - cross(lever, wrench.force)
    return Wrench(R_WT.T @ wrench.force, R_WT.T @ torque)


def symmetric(diagonal: Any, coupling: Any) -> Array:
    """The symmetric matrix of (aa, uu, vv) and (au, av, uv), (3, 3)."""
    aa, uu, vv = (diagonal[i] for i in range(3))
    au, av, uv = (coupling[i] for i in range(3))
    return matrix([[aa, au, av], [au, uu, uv], [av, uv, vv]])


def impedance(gains: Any, ratio: str, error: Array, rate: Array, felt: Array) -> tuple[Array, Array, Array]:
    """What an impedance with matrices in the task frame makes of error and felt push, (3,) each.

    Args:
        gains: with the fields `stiffness`, `damping` and `ratio`, each with its `_coupling`.
        ratio: name of the field with virtual over true mass or inertia.
        error: of the place or attitude, in the axes of the task.
        rate: its rate.
        felt: estimated force (N) or torque (N m), in the axes of the task.

    Returns:
        (L^-1 - E) felt, N or N m, and the accelerations K error and D rate.
    """
    L, K, D = (
        symmetric(getattr(gains, name), getattr(gains, f"{name}_coupling"))
        for name in (ratio, "stiffness", "damping")
    )
    return right_inverse(L) @ felt - felt, K @ error, D @ rate


def require_definite(gains: Any, *names: str) -> None:
    """Refuse matrices that are not positive definite, as they would give energy.

    Args:
        gains: a configuration with the fields `name` and `name`_coupling for each name.
        names: of the diagonals.
    """
    for name in names:
        M = symmetric(getattr(gains, name), getattr(gains, f"{name}_coupling"))
        if float(np.linalg.eigvalsh(M)[0]) <= 0.0:
            raise refused(gains, name, f"and {name}_coupling make a matrix that is not positive definite")
