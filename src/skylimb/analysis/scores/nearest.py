"""Which points of a line are nearest to some others, without looking at every pair.

Neighbours on a line, and samples one after the other, lie close together. So both are taken in blocks, and
a block of the ones is compared only with those blocks of the others that can hold what is nearest.
"""

from __future__ import annotations

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
    found = np.empty((len(points), count), dtype=int)
    if not len(points):
        return found
    begins, sizes, centres, radii = _blocks(points)
    _, their_sizes, their_centres, their_radii = _blocks(among)
    away = np.linalg.norm(centres[:, None] - their_centres, axis=2)
    # The nearest of any of a block's points are no farther than this, with room for rounding.
    reach = (away + their_radii).min(axis=1) + 2.0 * radii + 1e-9
    near = np.repeat(away - their_radii <= reach[:, None], their_sizes, axis=1)
    for begin, size, held in zip(begins, sizes, near, strict=True):
        candidates = np.flatnonzero(held)
        apart = points[begin : begin + size, None] - among[candidates]
        squares = np.einsum("ijk,ijk->ij", apart, apart)
        chosen = (
            squares.argmin(axis=1)[:, None]
            if count == 1
            else np.argpartition(squares, count - 1, axis=1)[:, :count]
        )
        found[begin : begin + size] = candidates[chosen]
    return found


def distances(points: np.ndarray, among: np.ndarray) -> np.ndarray:
    """The distance of each point to the nearest of the points `among`, m, (n,)."""
    return np.linalg.norm(points - among[nearest(points, among)[:, 0]], axis=1)


def _blocks(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Equal parts of a row of points: where each begins, its size, and a circle around it: middle, radius.

    Parts have `_BLOCK` points or up to half as few, so that each holds `count` points where there are many.
    """
    parts = -(-len(points) // _BLOCK)
    edges = np.linspace(0, len(points), parts + 1).astype(int)
    begins, sizes = edges[:-1], np.diff(edges)
    centres = np.add.reduceat(points, begins) / sizes[:, None]
    spread = np.linalg.norm(points - np.repeat(centres, sizes, axis=0), axis=1)
    return begins, sizes, centres, np.maximum.reduceat(spread, begins)
