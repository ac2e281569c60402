"""How much a line may be off, by its own size, and the move that lays one line best on another.

What one calls well drawn depends on the size of what is drawn. So a drawing may be beside its place by a
share of its size, and off its shape by a share of the corner or bow at hand, root mean square:

    allowed = min(most, max(finest, share * size)),

and a single place three times as far, a mark beside the line four times. What is drawn of a stroke may be
longer than the stroke by a share of it, and by some millimetres at its ends: what goes to and fro within all
this is no line.

The **feature** at a place of a line is the stretch around it along which the line turns by a quarter turn to
either side: half of a circle, a leg of a star, the whole of a straight line. Its size is the distance between
its ends.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from skylimb.analysis.scores.nearest import nearest

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

COARSE = 0.001
"""Spacing of the points of a thinned line, m: its length and its turns are not those of its trembling."""

FARTHEST, FARTHEST_MARK = 3.0, 4.0
"""How much farther than the root mean square a single place may be off, and a mark beside the line."""

_ENDS = 8.0
"""How much longer a stroke may be for what the pen draws as it begins and ends: so many times `finest`."""

_BEHIND_FINEST, _BEHIND = 8.0, 6.0
"""How far the pen may be from its reference of the moment, in times of what a line may be off."""

_QUARTER = 0.5 * np.pi
_ROUNDS = 6
_UNTOLD = 0.05
"""A move that changes distances less than this share of the one that changes them most is left alone."""
_MOST_POINTS = 1000


class Allowed(NamedTuple):
    """How far a line may be off, root mean square; of a log that says nothing what is usual.

    Attributes:
        of_size: share of its size.
        finest: however small it is, m.
        pen_line: however large it is, m.
        frechet: the greatest of a single place, m; else that is `FARTHEST` times as far.
        marks: the greatest of marks beside the line, m; else that is `FARTHEST_MARK` times as far.
        behind: how far the pen may be from its reference of the moment, however large its strokes are, m.
        longer: share by which what is drawn of a stroke may be longer than the stroke.
    """

    of_size: float = 0.05
    finest: float = 0.001
    pen_line: float = 0.020
    frechet: float = 0.020
    marks: float = 0.050
    behind: float = 0.100
    longer: float = 0.10

    @classmethod
    def stated(cls, tolerances: Mapping[str, float]) -> Allowed:
        """What an experiment's tolerances say."""
        return cls(**{name: tolerances[name] for name in cls._fields if name in tolerances})

    def of(self, size: Any) -> Any:
        """For sizes (m), m."""
        return np.minimum(self.pen_line, np.maximum(self.finest, self.of_size * size))

    def farthest(self, size: Any) -> Any:
        """Of a single place, for sizes (m), m."""
        return np.minimum(self.frechet, FARTHEST * np.maximum(self.finest, self.of_size * size))

    def farthest_mark(self, size: float) -> float:
        """Of a mark beside lines of a size (m), m."""
        return float(min(self.marks, FARTHEST_MARK * max(self.finest, self.of_size * size)))

    def behind_of(self, size: float) -> float:
        """From the reference of the moment, for strokes of a size (m), m."""
        return min(self.behind, max(_BEHIND_FINEST * self.finest, _BEHIND * self.of_size * size))

    def longest(self, length: float) -> float:
        """Of what is drawn of a stroke of a length (m), m."""
        return (1.0 + self.longer) * length + _ENDS * self.finest


def feature_sizes(line: np.ndarray) -> np.ndarray:
    """The size of the feature at each point of a line, (n, 2), m, (n,); see the module."""
    pieces = np.diff(line, axis=0)
    turns = np.diff(np.unwrap(np.arctan2(pieces[:, 1], pieces[:, 0])))
    turned = np.concatenate([[0.0], np.cumsum(np.abs(turns))])
    turned = np.append(turned, turned[-1])
    # At an end of the line the whole half turn lies to one side.
    first = np.clip(turned - _QUARTER, 0.0, max(turned[-1] - 2.0 * _QUARTER, 0.0))
    begin = np.searchsorted(turned, first, side="left")
    end = np.searchsorted(turned, first + 2.0 * _QUARTER, side="right") - 1
    return np.linalg.norm(line[end] - line[begin], axis=1)


def extent(lines: Sequence[np.ndarray]) -> float:
    """The longer side of the box around some lines, (n, 2) each."""
    return float(np.ptp(np.vstack(lines), axis=0).max())


def thinned(points: np.ndarray) -> np.ndarray:
    """A line, (n, 2), with points `COARSE` apart at least, but for its end."""
    kept = [0]
    for index, point in enumerate(points):
        if np.hypot(*(point - points[kept[-1]])) >= COARSE:
            kept.append(index)
    return points[[*kept, len(points) - 1] if kept[-1] < len(points) - 1 else kept]


def even(line: np.ndarray, pitch: float) -> np.ndarray:
    """The same line, (n, 2), with points as far apart all along it, `pitch` (m) at most."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    places = np.linspace(0.0, along[-1], int(np.ceil(along[-1] / pitch)) + 1)
    return np.stack([np.interp(places, along, axis) for axis in line.T], axis=1)


def at_most(points: np.ndarray, count: int) -> np.ndarray:
    """Evenly chosen of some points, (n, ...), with the first and the last."""
    if len(points) <= count:
        return points
    return points[np.linspace(0, len(points) - 1, count).round().astype(int)]


class Move(NamedTuple):
    """A rigid move of the plane: z -> turn z + shift, in complex numbers u + i v, |turn| = 1."""

    turn: complex = 1.0
    shift: complex = 0.0

    def of(self, points: np.ndarray) -> np.ndarray:
        """Points, (n, 2), moved."""
        moved = self.turn * (points @ [1.0, 1.0j]) + self.shift
        return np.stack([moved.real, moved.imag], axis=-1)


def best_move(drawn: Sequence[np.ndarray], wanted: Sequence[np.ndarray]) -> Move:
    """The rigid move that lays what was drawn best on what was wanted, in least squares of their distances.

    It begins with each stroke's middle, so that it does not lay one letter on the next. What distances do not
    tell, such as the turn of a circle, it leaves as it is.

    Args:
        drawn: points of each stroke, evenly spaced, (n, 2); some may be empty, which are left out.
        wanted: the same of what it should be, at least two points each.
    """
    pairs = [(one, other) for one, other in zip(drawn, wanted, strict=True) if len(one)]
    if not pairs:
        return Move()
    middles = [other.mean(axis=0) - one.mean(axis=0) for one, other in pairs]
    move = Move(shift=complex(*np.average(middles, axis=0, weights=[len(other) for _, other in pairs])))
    ours = at_most(np.vstack([one for one, _ in pairs]), _MOST_POINTS)
    theirs = np.vstack([other for _, other in pairs])
    ways = np.vstack([np.gradient(other, axis=0) for _, other in pairs])
    normals = ways[:, ::-1] * [1.0, -1.0] / np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-12)
    size = max(extent([theirs]), COARSE)
    for _ in range(_ROUNDS):
        moved = move.of(ours)
        middle = moved.mean(axis=0)
        beside = nearest(moved, theirs)
        across, arm = normals[beside], (moved - middle) / size
        turned = arm[:, 0] * across[:, 1] - arm[:, 1] * across[:, 0]
        error = np.sum(across * (theirs[beside] - moved), axis=1)
        by, *_ = np.linalg.lstsq(np.column_stack([across, turned]), error, rcond=_UNTOLD)
        turn, pivot = np.exp(1j * by[2] / size), complex(*middle)
        shift = turn * (move.shift - pivot) + pivot + complex(*by[:2])
        move = Move(complex(turn * move.turn), complex(shift))
    return move
