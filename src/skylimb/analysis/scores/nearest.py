"""Which point of a line is nearest to each of some others, without looking at every pair.

Neighbours on a line, and samples one after the other, lie close together. So both are taken in blocks, and
a block of the ones is compared only with those blocks of the others that can hold what is nearest. All such
pairs of blocks are compared at once, which takes as long as a search in SciPy's tree.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

_BLOCK = 16
"""Points that are taken together."""
_PAIRS = 256
"""Pairs of blocks that are compared at once, so that what they need stays in the processor's cache."""


_ROUNDING = 1e-9
"""m."""


class _Blocks(NamedTuple):
    """A row of points in blocks; the last one is filled up with its last point.

    Attributes:
        numbers: of the points, (blocks, 16).
        points: (blocks, 16, 2), m.
        centres: of the circle around each block, (blocks, 2), m.
        radii: (blocks,), m.
    """

    numbers: np.ndarray
    points: np.ndarray
    centres: np.ndarray
    radii: np.ndarray


def nearest(points: np.ndarray, among: np.ndarray) -> np.ndarray:
    """The number of the nearest of the points `among`, the first of equals, (n,).

    Args:
        points: (n, 2), m.
        among: (k, 2), m, at least one; those that follow each other lie close together.
    """
    found = np.empty(len(points), dtype=int)
    if not len(points):
        return found
    ours, theirs = _blocks(points), _blocks(among)
    away = _apart(ours, theirs)
    # The nearest of any of a block's points are no farther than this, with room for rounding.
    reach = (away + theirs.radii).min(axis=1) + 2.0 * ours.radii + _ROUNDING
    first, second = np.nonzero(away - theirs.radii <= reach[:, None])
    begins = np.searchsorted(first, np.arange(len(ours.numbers) + 1))
    begin = 0
    while begin < len(ours.numbers):
        end = max(begin + 1, np.searchsorted(begins, begins[begin] + _PAIRS, side="right") - 1)
        pairs = slice(begins[begin], begins[end])
        own, other = ours.points[first[pairs]], theirs.points[second[pairs]]
        x, y = (other[:, :, None, axis] - own[:, None, :, axis] for axis in (0, 1))
        squares = x * x + y * y
        least = np.minimum.reduceat(squares.min(axis=1), begins[begin:end] - begins[begin], axis=0)
        pair, place, point = np.nonzero(squares == least[first[pairs] - begin][:, None])
        # Written backwards: of equals the first one stays.
        held = ours.numbers[first[pairs][pair], point][::-1]
        found[held] = theirs.numbers[second[pairs][pair], place][::-1]
        begin = end
    return found


def distances(points: np.ndarray, among: np.ndarray) -> np.ndarray:
    """The distance of each point to the nearest of the points `among`, m, (n,)."""
    return np.linalg.norm(points - among[nearest(points, among)], axis=1)


def _apart(ours: _Blocks, theirs: _Blocks) -> np.ndarray:
    """Distances between the middles of blocks, m, (blocks, blocks)."""
    return np.hypot(*(ours.centres[:, None] - theirs.centres).transpose(2, 0, 1))


def _blocks(points: np.ndarray) -> _Blocks:
    count = -(-len(points) // _BLOCK)
    numbers = np.minimum(np.arange(count * _BLOCK), len(points) - 1).reshape(count, _BLOCK)
    held = points[numbers]
    centres = held.mean(axis=1)
    radii = np.linalg.norm(held - centres[:, None], axis=2).max(axis=1)
    return _Blocks(numbers, held, centres, radii)
