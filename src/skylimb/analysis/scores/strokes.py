"""The strokes that a pen drew, beside those that it was to draw.

**Place and shape** are told apart by the rigid move that lays all strokes together best on their reference.
How far that move takes the reference is the error of the place. What it leaves, stroke by stroke, is that of
the shape, held to what the size of its corners and bows allows (`skylimb.analysis.scores.fit`). The length of
what was drawn tells a line from one that goes to and fro along it.

Every mark counts: what the pen draws while it touches down, settles and leaves has its own distance from the
line. All of it in the sliding plane, as in `skylimb.analysis.scores.pen_line`.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from skylimb.analysis.scores.fidelity import Fidelity, fidelity, frechet
from skylimb.analysis.scores.fit import (
    COARSE,
    Allowed,
    at_most,
    best_move,
    even,
    extent,
    feature_sizes,
    thinned,
)
from skylimb.analysis.scores.nearest import distances, nearest
from skylimb.analysis.scores.pen_line import PITCH, dense, drawn_samples, marks, reference_line
from skylimb.analysis.scores.signals import in_contact, in_phase, phase_names, spacing, stretches

if TYPE_CHECKING:
    import xarray as xr

_WAITS = 2.5
"""So many ticks before a lift's last may a clock stand that waits for touch: it stands between ticks, too."""

_SPARSE = 2.0 * COARSE
"""Spacing of a drawn line's points at most, m: it is the line between the samples that is compared."""

_SHAPE_POINTS = 600
"""Points of a reference line at most where what is allowed is wider than their spacing."""


EXCESSES = ("excess_drawn", "excess_missing", "excess_place")
"""What a `Stroke` may miss its shape by, in the order in which the first that misses is reported."""

ENDS = ("excess_begin", "excess_end")
"""What of a `Stroke` may be all that its single place is off by."""


@dataclass(frozen=True)
class Stroke(Fidelity):
    """A stroke in its place, and its shape once the place of the whole drawing is taken off.

    Attributes:
        shape: distance of the moved stroke from its reference, root mean square, m.
        excess: how many times as far as its corners and bows allow it is off its shape, the greatest of the
            next three.
        excess_drawn: by the root mean square of drawn places.
        excess_missing: by that of reference places.
        excess_place: by the Frechet distance, of a single place.
        excess_begin: how many times as far as a single place may be off its first drawn place is from its
            beginning; the Frechet distance has this in it, however well the rest is drawn.
        excess_end: the same of its last drawn place and its end.
        excess_backwards: the Frechet distance if it is drawn from its end to its beginning; no number where
            no single place is far off.
        covered: share of the stroke's length that is drawn, no farther off than a single place may be.
        longest: how long what is drawn of it may be, m.
        kept: whether it was drawn, keeps its shape, and is not drawn to and fro.
    """

    shape: float
    excess: float
    excess_drawn: float
    excess_missing: float
    excess_place: float
    excess_begin: float
    excess_end: float
    excess_backwards: float
    covered: float
    longest: float
    kept: bool


class Drawn(NamedTuple):
    """A whole drawing.

    Attributes:
        whole: all strokes, one behind the other.
        place: how far the move that lays it best on its reference takes it, root mean square, m.
        place_allowed: of that, for its size, m.
        marks: farthest that a mark of touching down, settling and leaving is from the line, m; 0 for none.
        marks_allowed: of that, for its size, m.
        strokes: one by one.
    """

    whole: Fidelity
    place: float
    place_allowed: float
    marks: float
    marks_allowed: float
    strokes: tuple[Stroke, ...]


def drawn_line(log: xr.Dataset) -> Drawn | None:
    """How faithfully a line was drawn, whole and stroke by stroke; None where there is no reference line.

    Where there are more lifts than between the strokes, all that was drawn belongs to the first. Of a flight
    that was stopped the first ones are there.
    """
    lines = reference_line(log)
    if not lines:
        return None
    allowed = Allowed.stated(json.loads(log.attrs.get("tolerances", "{}")))
    size = extent(lines)
    samples, points = drawn_samples(log)
    begins = stroke_begins(log)
    parts = np.searchsorted(begins if len(begins) <= len(lines) else begins[:1], samples, side="right") - 1
    drawn = [list(_pieces(samples[parts == index], points[parts == index])) for index in range(len(lines))]
    wanted = [dense(thinned(line)) for line in lines]
    move = best_move(
        [np.vstack([np.zeros((0, 2)), *(even(piece, PITCH) for piece in pieces)]) for pieces in drawn],
        [even(line, PITCH) for line in wanted],
    )
    there = np.vstack(wanted)
    taken = np.linalg.norm(move.of(there) - there, axis=1) if len(samples) else np.array([np.nan])
    numbers, touched = marks(log)
    besides = touched[~np.isin(numbers, samples)]
    strokes = tuple(
        _stroke(fidelity([line], pieces), dense_line, [move.of(piece) for piece in pieces], allowed)
        for line, dense_line, pieces in zip(lines, wanted, drawn, strict=True)
    )
    return Drawn(
        strokes[0] if len(strokes) == 1 else fidelity(lines, [piece for pieces in drawn for piece in pieces]),
        float(np.sqrt(np.mean(taken**2))),
        float(allowed.of(size)),
        float(distances(move.of(besides), there).max(initial=0.0)),
        allowed.farthest_mark(size),
        strokes,
    )


def _stroke(placed: Fidelity, wanted: np.ndarray, drawn: list[np.ndarray], allowed: Allowed) -> Stroke:
    """A stroke with its shape.

    Args:
        placed: how faithful it is in its place.
        wanted: its reference, (n, 2), m.
        drawn: what was drawn of it, moved; (k, 2) each, m.
        allowed: how far it may be off.
    """
    longest = allowed.longest(placed.length)
    if not drawn:
        none = dict.fromkeys(("shape", "excess", *EXCESSES, *ENDS, "excess_backwards"), np.nan)
        return Stroke(**asdict(placed), **none, covered=0.0, longest=longest, kept=False)
    points, sizes = np.vstack(drawn), feature_sizes(wanted)
    most, farthest = allowed.of(sizes), allowed.farthest(sizes)
    beside = nearest(points, wanted)
    off, missing = np.linalg.norm(points - wanted[beside], axis=1), distances(wanted, points)
    line, unit = at_most(wanted, _SHAPE_POINTS), at_most(farthest, _SHAPE_POINTS)
    ratios = (
        float(np.sqrt(np.mean((off / most[beside]) ** 2))),
        float(np.sqrt(np.mean((missing / most) ** 2))),
        frechet(line, points, unit),
    )
    ends = np.linalg.norm(points[[0, -1]] - wanted[[0, -1]], axis=1) / farthest[[0, -1]]
    return Stroke(
        **asdict(placed),
        shape=float(np.sqrt(np.mean(off**2))),
        excess=max(ratios),
        **dict(zip(EXCESSES, ratios, strict=True)),
        **dict(zip(ENDS, map(float, ends), strict=True)),
        excess_backwards=frechet(line, points[::-1], unit) if ratios[2] > 1.0 else np.nan,
        covered=float(np.mean(missing <= farthest)),
        longest=longest,
        kept=bool(max(ratios) <= 1.0 and placed.drawn <= longest),
    )


def stroke_begins(log: xr.Dataset) -> np.ndarray:
    """The sample from which on a touch belongs to each stroke, (strokes,).

    A lift is divided where the pen was off the surface for the longest time: what it drew before is the tail
    of the last stroke, what it drew after is the lead to the next. A pen that never left divides it in its
    middle.
    """
    touching, found = in_contact(log), [0]
    for begin, end in stretches(lifted(log)):
        away = [(stop - start, start, stop) for start, stop in stretches(~touching[begin:end])]
        _, start, stop = max(away, default=(0, 0, end - begin))
        found.append(begin + (start + stop) // 2)
    return np.array(found)


def lifted(log: xr.Dataset) -> np.ndarray:
    """At which samples the pen is to be lifted, between the first stroke and the last, (time,)."""
    if "lift" not in phase_names(log):
        return np.zeros(log.sizes["time"], dtype=bool)
    return in_phase(log, "lift")


def held_off(log: xr.Dataset) -> np.ndarray:
    """At which samples of its lifts the pen was to be off the surface, (time,).

    A lift ends for the pen where the mission's clock has come to its end. A law that stops the clock there
    until it feels the surface is landing: a touch is what it waits for.
    """
    away = lifted(log)
    if "mission_time" in log:
        clock, step = log.mission_time.values, spacing(log.time.values)
        for begin, end in stretches(away):
            away[begin:end] = clock[begin:end] < clock[end - 1] - _WAITS * step - 1e-9
    return away


def _pieces(samples: np.ndarray, points: np.ndarray) -> Iterator[np.ndarray]:
    """What was drawn from touch to loss of touch, with points `COARSE` to `_SPARSE` apart."""
    for piece in np.split(points, np.flatnonzero(np.diff(samples) > 1) + 1):
        if len(piece):
            yield dense(thinned(piece), _SPARSE)
