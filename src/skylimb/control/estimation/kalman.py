"""The two halves of a Kalman filter, written so that they run compiled.

    P <- F P F^T + Q,                                        from one tick to the next
    k = P h / (h . P h + r),  x <- x + k e,  P <- P - k (P h)^T      one number of a measurement

Several numbers whose errors are independent are taken in one after the other, which is the same as all at
once and inverts no matrix.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from skylimb.symbolic import Array, dot, is_symbolic, matrix


def corrected(x: Array, P: Array, h: Array, innovation: Any, noise: Any, weight: Any) -> tuple[Array, Array]:
    """The state and its covariance, which know a scalar measurement h . x.

    Args:
        x: (n,).
        P: (n, n), symmetric.
        h: (n,).
        innovation: by how much the measurement differs from what x says.
        noise: its variance.
        weight: 0 to 1: how much it counts.
    """
    Ph = P @ h
    gain = weight * Ph / (dot(h, Ph) + noise)
    return x + gain * innovation, P - outer(gain, Ph)


def propagated(P: Array, F: Array, drift: Array) -> Array:
    """The covariance a step later: F P F^T, and what each state drifts by, (n,), on its diagonal."""
    return F @ P @ F.T + (ca.diag(drift) if is_symbolic(drift) else np.diag(drift))


def outer(a: Array, b: Array) -> Array:
    """The matrix a b^T of two vectors."""
    if not is_symbolic(a, b):
        return np.outer(a, b)
    return matrix([[a[i] * b[j] for j in range(b.shape[0])] for i in range(a.shape[0])])


def mirrored(P: Array) -> Array:
    """A symmetric matrix by its lower half alone: half the work once compiled."""
    return ca.tril2symm(ca.tril(P)) if is_symbolic(P) else np.tril(P) + np.tril(P, -1).T


def unit_but_for(size: int, blocks: Mapping[tuple[int, int], Array]) -> Array:
    """The unit matrix with other blocks at some rows and columns; in symbols its zeros cost nothing."""
    kinds = [type(block) for block in blocks.values() if is_symbolic(block)]
    M = kinds[0].eye(size) if kinds else np.eye(size)
    for (row, column), block in blocks.items():
        M[row : row + block.shape[0], column : column + block.shape[1]] = block
    return M


class Seen(NamedTuple):
    """Three numbers of a measurement whose errors are independent of one another.

    Attributes:
        shows: what they show of the state: by where three of its numbers begin, a matrix (3, 3).
        off: by how much they differ from what the state says, (3,).
        noise: standard deviation of each.
        weight: 1 where they count, else 0.
    """

    shows: Mapping[int, Array]
    off: Array
    noise: Any
    weight: Any


def taken_in(P: Array, measured: Sequence[Seen]) -> tuple[Array, Array]:
    """By how much the state is off as all that is measured says, (n,), and the covariance that is left."""
    x = np.zeros(P.shape[0])
    for seen in measured:
        for axis in range(3):
            h = _row(P, seen.shows, axis)
            x, P = corrected(x, P, h, seen.off[axis] - dot(h, x), seen.noise**2, seen.weight)
            P = mirrored(P)
    return x, P


def _row(P: Array, shows: Mapping[int, Array], axis: int) -> Array:
    """One row of what is shown, (n,), of the kind of the covariance."""
    h = type(P)(P.shape[0], 1) if is_symbolic(P) else np.zeros(P.shape[0])
    for column, block in shows.items():
        for k in range(3):
            h[column + k] = block[axis, k]
    return h
