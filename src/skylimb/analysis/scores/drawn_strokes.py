"""How faithfully the pen drew its strokes: in their order, all of them, and nothing besides.

The distance to the nearest point of the reference line forgives a cut corner, a line that is drawn at another
time, and a stroke that is not there. What stands here does not:

- the **Frechet distance**, the shortest leash between two who walk along the reference line and along the
  drawn one from end to end, neither ever going back;
- the **Hausdorff distances** both ways: the place of the reference line that is farthest from anything drawn
  (what is missing), and the drawn place that is farthest from the line (what is too much);
- the **lengths** of what was drawn and of what was commanded;
- the **touch while lifted**, between two strokes.

All of it in the sliding plane, as in `skylimb.analysis.scores.pen_line`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.nearest import distances
from skylimb.analysis.scores.pen_line import dense, drawn_samples, reference_line
from skylimb.analysis.scores.score import DRAWING, Score, Tolerance, metric
from skylimb.analysis.scores.signals import in_contact, in_phase, phase_names, stretches

if TYPE_CHECKING:
    import xarray as xr

COARSE = 0.001
"""Spacing of the points of a drawn line, m: its length is not that of the pen's trembling."""

_MOST_POINTS = 2000
"""Points of each line for the Frechet distance at most; its memory grows with their square."""


class Fidelity(NamedTuple):
    """How faithfully a line was drawn; m and s. NaN where nothing of it was drawn.

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


def _drawn(meaning: str, row: str, **more: Any) -> Score:
    return Score(meaning, "m", group=DRAWING, row=row, ranked=False, **more)


@metric(
    keys={
        "frechet": _drawn(
            "Frechet distance between the drawn lines and their reference, in their order",
            "Frechet distance to its reference, in the strokes' order",
            smaller_is_better=True,
            tolerance=Tolerance(
                "frechet",
                "the drawing is {value} from its reference in the strokes' order (Frechet), {bound} allowed",
            ),
        ),
        "missing_max": _drawn(
            "Farthest that a place of the reference line is from what was drawn",
            "farthest place of the reference from what was drawn",
            smaller_is_better=True,
        ),
        "length": _drawn("Length of the reference line", "length of the reference"),
        "length_drawn": _drawn("Length of what was drawn", "length drawn"),
    }
)
def line(run: Run) -> dict[str, float]:
    """How faithfully a drawing was drawn; no numbers of a flight that had none."""
    whole = whole_line(run.log) if "reference_line" in run.log else None
    if whole is None:
        return dict.fromkeys(("frechet", "missing_max", "length", "length_drawn"), np.nan)
    return {
        "frechet": whole.frechet,
        "missing_max": whole.missing,
        "length": whole.length,
        "length_drawn": whole.drawn,
    }


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


def whole_line(log: xr.Dataset) -> Fidelity | None:
    """How faithfully all strokes were drawn, one behind the other; None where there is no reference line."""
    lines = reference_line(log)
    return fidelity(lines, list(_pieces(*drawn_samples(log)))) if lines else None


def strokes_of(log: xr.Dataset) -> tuple[Fidelity, ...]:
    """How faithfully each stroke of a drawing was drawn; none where they cannot be told apart."""
    if "reference_line" not in log or not in_phase(log, "slide").any():
        return ()
    lines, begins = reference_line(log), stroke_begins(log)
    if len(begins) != len(lines):
        return ()
    samples, points = drawn_samples(log)
    parts = np.searchsorted(begins, samples, side="right") - 1
    return tuple(
        fidelity([line], list(_pieces(samples[parts == index], points[parts == index])))
        for index, line in enumerate(lines)
    )


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


def frechet(first: np.ndarray, second: np.ndarray) -> float:
    """The discrete Frechet distance of two rows of points (n, 2), (m, 2), m; thinned where they are many.

    With d the distances and c the shortest leash up to a pair of points,
    c_ij = max(d_ij, min(c_i-1,j, c_i-1,j-1, c_i,j-1)). Along a diagonal i + j = k no entry needs another, so
    each is one operation on arrays, and no matrix is kept. (GEOS, which shapely calls, needs seconds where
    this needs tenths, and ends the process at some thousand points.)
    """
    first, second = (_at_most(points, _MOST_POINTS) for points in (first, second))
    n, m = len(first), len(second)
    # By i; what is not on the diagonal is no way.
    last, before = np.full(n + 1, np.inf), np.full(n + 1, np.inf)
    before[0] = -np.inf
    for k in range(n + m - 1):
        i = np.arange(max(0, k - m + 1), min(k, n - 1) + 1)
        apart = np.hypot(*(first[i] - second[k - i]).T)
        here = np.full(n + 1, np.inf)
        here[i + 1] = np.maximum(apart, np.minimum(np.minimum(last[i], last[i + 1]), before[i]))
        last, before = here, last
    return float(last[n])


def _at_most(points: np.ndarray, count: int) -> np.ndarray:
    if len(points) <= count:
        return points
    return points[np.linspace(0, len(points) - 1, count).round().astype(int)]


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
            yield _thinned(piece)


def _thinned(points: np.ndarray) -> np.ndarray:
    kept = [0]
    for index, point in enumerate(points):
        if np.hypot(*(point - points[kept[-1]])) >= COARSE:
            kept.append(index)
    return points[kept]


def _length(line: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
