"""How faithfully the pen drew its strokes: in their order, all of them, and nothing besides.

The distance to the nearest point of the reference line forgives a cut corner, a line that is drawn at another
time, and a stroke that is not there. What stands here does not:

- the Frechet and Hausdorff distances and the lengths, in its place (`skylimb.analysis.scores.fidelity`);
- the **touch while lifted**, between two strokes.

**Place and shape** are told apart by the rigid move that lays all strokes together best on their reference.
How far that move takes the reference is the error of the place. What it leaves, stroke by stroke, is that of
the shape, held to what the size of its corners and bows allows (`skylimb.analysis.scores.fit`).

Every mark counts: what the pen draws while it touches down, settles and leaves has its own distance from the
line. All of it in the sliding plane, as in `skylimb.analysis.scores.pen_line`.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.fidelity import Fidelity, fidelity, frechet
from skylimb.analysis.scores.fit import Allowed, at_most, best_move, extent, feature_sizes, thinned
from skylimb.analysis.scores.nearest import distances, nearest
from skylimb.analysis.scores.pen_line import dense, drawn_samples, marks, reference_line
from skylimb.analysis.scores.score import DRAWING, Score, Tolerance, metric
from skylimb.analysis.scores.signals import in_contact, in_phase, phase_names, stretches

if TYPE_CHECKING:
    import xarray as xr

DRAWN = "drawn"
"""Where a run's metrics hold what was drawn, for whoever has it already."""

_SHAPE_POINTS = 600
"""Points of a reference line at most where what is allowed is wider than their spacing."""


@dataclass(frozen=True)
class Stroke(Fidelity):
    """A stroke in its place, and its shape once the place of the whole drawing is taken off.

    Attributes:
        shape: distance of the moved stroke from its reference, root mean square, m.
        excess: how many times as far as its corners and bows allow it is off its shape; by the root mean
            square of drawn places and of reference places, and by the Frechet distance, the greatest of all.
        covered: share of the stroke's length that is drawn, no farther off than a single place may be.
        kept: whether it was drawn and keeps its shape.
    """

    shape: float
    excess: float
    covered: float
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


_OF_A_LINE = (
    "frechet", "missing_max", "length", "length_drawn", "place", "place_allowed", "marks", "marks_allowed",
    "shape", "covered", "strokes_missed",
)  # fmt: skip


def _drawn(meaning: str, row: str, **more: Any) -> Score:
    return Score(meaning, "m", group=DRAWING, row=row, ranked=False, **more)


def _missed_strokes(run: Run) -> str:
    strokes = run.metrics["strokes"]
    worst = max(strokes, key=lambda stroke: np.inf if stroke["excess"] is None else stroke["excess"])
    missed = sum(not stroke["kept"] for stroke in strokes)
    which = f"stroke {strokes.index(worst) + 1} of {len(strokes)}" if len(strokes) > 1 else "the line"
    others = f" (and {missed - 1} more)" if missed > 1 else ""
    if worst["excess"] is None:
        return f"{which} is not drawn{others}"
    return (
        f"{which} is off its shape by {worst['excess']:.1f} times what its corners and bows allow, "
        f"{1e3 * worst['shape']:.1f} mm root mean square{others}"
    )


@metric(
    keys={
        "frechet": _drawn(
            "Frechet distance between the drawn lines and their reference, in their order",
            "Frechet distance to its reference, in the strokes' order",
            smaller_is_better=True,
        ),
        "missing_max": _drawn(
            "Farthest that a place of the reference line is from what was drawn",
            "farthest place of the reference from what was drawn",
            smaller_is_better=True,
        ),
        "length": _drawn("Length of the reference line", "length of the reference"),
        "length_drawn": _drawn("Length of what was drawn", "length drawn"),
        "place": _drawn(
            "How far the drawn lines are beside their place: the rigid move that lays them best on it, root "
            "mean square",
            "beside its place: the best rigid move, root mean square",
            smaller_is_better=True,
            tolerance=Tolerance(
                "pen_line",
                "the line lies {value} beside its place, {bound} allowed for its size",
                scaled=lambda run: run.metrics["line_place_allowed"],
            ),
        ),
        "place_allowed": _drawn(
            "How far they may be beside it for their size", "allowed of that for its size"
        ),
        "marks": _drawn(
            "Farthest mark of touching down, settling and leaving from the line, the place taken off",
            "farthest mark of touching down, settling and leaving",
            smaller_is_better=True,
            tolerance=Tolerance(
                "marks",
                "touching down, settling and leaving mark the surface up to {value} beside the line, "
                "{bound} allowed for its size",
                scaled=lambda run: run.metrics["line_marks_allowed"],
            ),
        ),
        "marks_allowed": _drawn("How far such a mark may be for the size of the lines", "allowed of that"),
        "shape": _drawn(
            "Distance of the strokes from their shape, the place of all taken off, root mean square",
            "off its shape: its place taken off, root mean square",
            smaller_is_better=True,
        ),
        "covered": Score(
            "Share of the reference line that is drawn within what its corners and bows allow, the place of "
            "all taken off",
            smaller_is_better=False,
            group=DRAWING,
            row="drawn within what its corners and bows allow",
            ranked=False,
            tolerance=Tolerance("path", "{value} of the line is drawn, {bound} commanded"),
        ),
        "strokes_missed": Score(
            "Strokes that are not drawn, or farther from their shape than their corners and bows allow",
            smaller_is_better=True,
            group=DRAWING,
            row="strokes that miss their shape",
            kind="count",
            ranked=False,
            tolerance=Tolerance("strokes", _missed_strokes),
        ),
    }
)
def line(run: Run) -> dict[str, float]:
    """How faithfully the reference line was drawn; no numbers of a flight that had none."""
    drawn = run.metrics.get(DRAWN) or drawn_line(run.log)
    if drawn is None:
        return dict.fromkeys(_OF_A_LINE, np.nan)
    whole = drawn.whole
    lengths = [stroke.length for stroke in drawn.strokes]
    shapes = np.average([stroke.shape**2 for stroke in drawn.strokes], weights=lengths)
    covered = np.average([stroke.covered for stroke in drawn.strokes], weights=lengths)
    missed = sum(not stroke.kept for stroke in drawn.strokes)
    values = (whole.frechet, whole.missing, whole.length, whole.drawn, *drawn[1:5])
    return dict(zip(_OF_A_LINE, (*values, float(np.sqrt(shapes)), float(covered), missed), strict=True))


@metric(
    keys={
        "time": Score(
            "Time for which the pen was to be lifted",
            "s",
            group=DRAWING,
            row="time for which the pen was to be lifted",
        ),
        "touch_time": Score(
            "Time of touch while it was to be lifted",
            "s",
            smaller_is_better=True,
            group=DRAWING,
            row="touch in that time",
            ranked=False,
            tolerance=Tolerance(
                "lifted",
                "the pen touches {value} of the time of its lifts, {bound} allowed",
                per=lambda run: run.metrics["lift_time"],
            ),
        ),
    }
)
def lift(run: Run) -> dict[str, float]:
    """Time of a drawing's lifts, and of touch within them."""
    log = run.log
    if "reference_line" not in log or not reference_line(log):
        return {"time": np.nan, "touch_time": np.nan}
    away, step = lifted(log), float(np.diff(log.time.values[:2])[0])
    touch = step * float((away & in_contact(log)).sum())
    return {"time": step * float(away.sum()), "touch_time": touch}


def drawn_line(log: xr.Dataset) -> Drawn | None:
    """How faithfully a line was drawn, whole and stroke by stroke; None where there is no reference line.

    Where strokes cannot be told apart, all that was drawn belongs to the first.
    """
    lines = reference_line(log)
    if not lines:
        return None
    allowed = Allowed.stated(json.loads(log.attrs.get("tolerances", "{}")))
    size = extent(lines)
    samples, points = drawn_samples(log)
    begins = stroke_begins(log)
    parts = np.searchsorted(begins if len(begins) == len(lines) else begins[:1], samples, side="right") - 1
    drawn = [list(_pieces(samples[parts == index], points[parts == index])) for index in range(len(lines))]
    wanted = [dense(thinned(line)) for line in lines]
    move = best_move([np.vstack([np.zeros((0, 2)), *map(dense, pieces)]) for pieces in drawn], wanted)
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
        float(allowed.farthest(size, allowed.marks)),
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
    if not drawn:
        return Stroke(**asdict(placed), shape=np.nan, excess=np.nan, covered=0.0, kept=False)
    points, sizes = np.vstack(drawn), feature_sizes(wanted)
    most, farthest = allowed.of(sizes), allowed.farthest(sizes, allowed.frechet)
    beside = nearest(points, wanted)
    off, missing = np.linalg.norm(points - wanted[beside], axis=1), distances(wanted, points)
    ratios = (
        np.sqrt(np.mean((off / most[beside]) ** 2)),
        np.sqrt(np.mean((missing / most) ** 2)),
        frechet(at_most(wanted, _SHAPE_POINTS), points, at_most(farthest, _SHAPE_POINTS)),
    )
    return Stroke(
        **asdict(placed),
        shape=float(np.sqrt(np.mean(off**2))),
        excess=float(max(ratios)),
        covered=float(np.mean(missing <= farthest)),
        kept=bool(max(ratios) <= 1.0),
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


def _pieces(samples: np.ndarray, points: np.ndarray) -> Iterator[np.ndarray]:
    """What was drawn from touch to loss of touch, with points `COARSE` apart at least."""
    for piece in np.split(points, np.flatnonzero(np.diff(samples) > 1) + 1):
        if len(piece):
            yield thinned(piece)
