"""How faithful one line is to another in its place, in the order in which both are drawn.

- The **Frechet distance** is the shortest leash between two who walk along the reference line and along the
  drawn one from end to end, neither ever going back.
- The **Hausdorff distances** both ways: the place of the reference line that is farthest from anything drawn
  (what is missing), and the drawn place that is farthest from the line (what is too much).
- The **lengths** of what was drawn and of what was commanded.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skylimb.analysis.scores.fit import at_most
from skylimb.analysis.scores.nearest import distances
from skylimb.analysis.scores.pen_line import dense

_MOST_POINTS = 2000
"""Points of each line for the Frechet distance at most; its time grows with their square."""


@dataclass(frozen=True)
class Fidelity:
    """How faithfully a line was drawn in its place, m. NaN where nothing of it was drawn.

    Attributes:
        frechet: Frechet distance between the reference line and the drawn one.
        missing: farthest that a place of the reference line is from what was drawn.
        stray: farthest that a drawn place is from the reference line.
        length: of the reference line.
        drawn: length of what was drawn, tails included.
    """

    frechet: float
    missing: float
    stray: float
    length: float
    drawn: float


def fidelity(lines: list[np.ndarray], pieces: list[np.ndarray]) -> Fidelity:
    """How faithfully some lines were drawn.

    Args:
        lines: reference, one (n, 2) a stroke, m, in their order.
        pieces: what was drawn without leaving the surface, (k, 2) each, m, in the order of time.
    """
    length = sum(_length(line) for line in lines)
    if not pieces:
        return Fidelity(float("nan"), float("nan"), float("nan"), length, 0.0)
    wanted, drawn = np.vstack([dense(line) for line in lines]), np.vstack(pieces)
    return Fidelity(
        frechet(wanted, drawn),
        float(distances(wanted, drawn).max()),
        float(distances(drawn, wanted).max()),
        length,
        sum(_length(piece) for piece in pieces),
    )


def frechet(first: np.ndarray, second: np.ndarray, unit: np.ndarray | None = None) -> float:
    """The discrete Frechet distance of two rows of points (n, 2), (m, 2), m; thinned where they are many.

    With d the distances and c the shortest leash up to a pair of points,
    c_ij = max(d_ij, min(c_i-1,j, c_i-1,j-1, c_i,j-1)). Along a diagonal i + j = k no entry needs another, so
    each is one operation on arrays, and no matrix is kept. (GEOS, which shapely calls, needs seconds where
    this needs tenths, and ends the process at some thousand points.)

    Args:
        first: a line.
        second: another.
        unit: in which the leash is measured at each point of the first, (n,); m when absent.
    """
    unit = np.ones(len(first)) if unit is None else unit
    first, second, unit = (at_most(part, _MOST_POINTS) for part in (first, second, unit))
    n, m = len(first), len(second)
    x, y = (first.T[axis].copy() for axis in (0, 1))
    x_back, y_back = (second[::-1].T[axis].copy() for axis in (0, 1))
    # By i; what is beside the diagonal is no way.
    here, last, before = np.full((3, n + 2), np.inf)
    before[0] = -np.inf
    for k in range(n + m - 1):
        low, high = max(0, k - m + 1), min(k, n - 1) + 1
        ours, theirs = slice(low, high), slice(m - 1 - k + low, m - 1 - k + high)
        apart = np.hypot(x[ours] - x_back[theirs], y[ours] - y_back[theirs]) / unit[ours]
        way = np.minimum(np.minimum(last[ours], last[low + 1 : high + 1]), before[ours])
        np.maximum(apart, way, out=here[low + 1 : high + 1])
        here[low] = here[high + 1] = np.inf
        here, last, before = before, here, last
    return float(last[n])


def _length(line: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
