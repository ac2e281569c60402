"""Which points of a line are nearest to some others, without looking at every pair.

Neighbours on a line, and samples one after the other, lie close together. So both are taken in blocks, and
a block of the ones is compared only with those blocks of the others that can hold what is nearest.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

_BLOCK = 16
"""Points that are taken together."""


def nearest(points: np.ndarray, among: np.ndarray, count: int = 1) -> np.ndarray:
    """The numbers of the `count` nearest of the points `among`, in any order, (n, count).

    Args:
        points: (n, 2), m.
        among: (k, 2), m, at least `count` of them; those that follow each other lie close together.
        count: at most 8.
    """
    numbers = np.arange(len(among))
    blocks = list(_blocks(numbers))
    circles = [_circle(among[block]) for block in blocks]
    centres, radii = np.array([centre for centre, _ in circles]), np.array([radius for _, radius in circles])
    found = np.empty((len(points), count), dtype=int)
    for block in _blocks(np.arange(len(points))):
        centre, radius = _circle(points[block])
        away = np.linalg.norm(centres - centre, axis=1)
        # The nearest of any of these points are no farther than this, with room for rounding.
        near = away - radii <= (away + radii).min() + 2.0 * radius + 1e-9
        candidates = np.concatenate([blocks[k] for k in np.flatnonzero(near)])
        squares = np.sum((points[block][:, None] - among[candidates]) ** 2, axis=-1)
        found[block] = candidates[np.argpartition(squares, count - 1, axis=1)[:, :count]]
    return found


def distances(points: np.ndarray, among: np.ndarray) -> np.ndarray:
    """The distance of each point to the nearest of the points `among`, m, (n,)."""
    return np.linalg.norm(points - among[nearest(points, among)[:, 0]], axis=1)


def _blocks(numbers: np.ndarray) -> Iterator[np.ndarray]:
    """Equal parts, so that none has fewer than half of `_BLOCK` but where there are no more."""
    yield from np.array_split(numbers, -(-len(numbers) // _BLOCK)) if len(numbers) else ()


def _circle(points: np.ndarray) -> tuple[np.ndarray, float]:
    centre = points.mean(axis=0)
    return centre, float(np.linalg.norm(points - centre, axis=1).max())
