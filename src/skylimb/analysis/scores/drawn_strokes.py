"""Scores of a drawing: whether the strokes are all there, in their order, where they should be, and alone.

The distance to the nearest point of the reference line forgives a cut corner, a line that is drawn at another
time, and a stroke that is not there. What stands here does not:

- the Frechet and Hausdorff distances and the lengths, in its place (`skylimb.analysis.scores.fidelity`);
- place and shape, told apart (`skylimb.analysis.scores.strokes`);
- the **touch while lifted**, between two strokes.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.pen_line import reference_line
from skylimb.analysis.scores.score import DRAWING, Score, Tolerance, metric
from skylimb.analysis.scores.signals import in_contact, spacing
from skylimb.analysis.scores.strokes import ENDS, EXCESSES, drawn_line, held_off
from skylimb.analysis.scores.verdict import quantities

DRAWN = "drawn"
"""Where a run's metrics hold what was drawn, for whoever has it already."""


_OF_A_LINE = (
    "frechet", "missing_max", "length", "length_drawn", "place", "place_allowed", "marks", "marks_allowed",
    "shape", "covered", "strokes_missed",
)  # fmt: skip


def _drawn(meaning: str, row: str, **more: Any) -> Score:
    return Score(meaning, "m", group=DRAWING, row=row, ranked=False, **more)


def _excess(stroke: dict[str, Any]) -> float:
    """How far a stroke is beyond what is allowed of its shape, or of its length if that is more."""
    if stroke["excess"] is None:
        return np.inf
    return max(stroke["excess"], stroke["drawn"] / stroke["longest"])


def _missed_strokes(run: Run) -> str:
    strokes = run.metrics["strokes"]
    worst = max(strokes, key=_excess)
    missed = sum(not stroke["kept"] for stroke in strokes)
    which = f"stroke {strokes.index(worst) + 1} of {len(strokes)}" if len(strokes) > 1 else "the line"
    others = f" (and {missed - 1} more)" if missed > 1 else ""
    if worst["excess"] is None:
        return f"{which} is not drawn{others}"
    drawn, length, longest = (f"{1e3 * worst[name]:.0f} mm" for name in ("drawn", "length", "longest"))
    if worst["excess"] <= 1.0:
        return f"{which} is drawn to and fro: {drawn} for its {length}, {longest} allowed{others}"
    told = next(name for name in EXCESSES if worst[name] > 1.0)
    if told == "excess_place" and worst["excess_backwards"] <= 1.0:
        return f"{which} is drawn backwards, from its end to its beginning{others}"
    end = max(ENDS, key=lambda name: worst[name])
    if told == "excess_place" and worst[end] > worst[told] * (1.0 - 1e-9):
        told = end
    what = {
        "excess_drawn": f"the shape of {which} is {1e3 * worst['shape']:.1f} mm off (root mean square)",
        "excess_missing": f"places of {which} are far from all that was drawn (root mean square)",
        "excess_place": f"a single place of {which} is far off its shape",
        "excess_begin": f"{which} begins far from its beginning",
        "excess_end": f"{which} ends far from its end",
    }[told]
    excess, _ = quantities(worst[told], 1.0, "times")
    return f"{what}, {excess} what is allowed{others}"


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
            "beside its place, root mean square",
            smaller_is_better=True,
            tolerance=Tolerance(
                "pen_line",
                "the line lies {value} beside its place, {bound} allowed",
                scaled=lambda run: run.metrics["line_place_allowed"],
            ),
        ),
        "place_allowed": _drawn(
            "How far they may be beside it for their size", "allowed beside its place, for its size"
        ),
        "marks": _drawn(
            "Farthest mark of touching down, settling and leaving from the line, the place taken off",
            "farthest mark before and after the line",
            smaller_is_better=True,
            tolerance=Tolerance(
                "marks",
                "before and after the line the pen leaves marks up to {value} beside it, {bound} allowed",
                scaled=lambda run: run.metrics["line_marks_allowed"],
            ),
        ),
        "marks_allowed": _drawn(
            "How far such a mark may be for the size of the lines", "allowed for such marks"
        ),
        "shape": _drawn(
            "Distance of the strokes from their shape, the place of all taken off, root mean square",
            "off its shape, root mean square",
            smaller_is_better=True,
        ),
        "covered": Score(
            "Share of the reference line that is drawn within what its corners and bows allow, the place of "
            "all taken off",
            smaller_is_better=False,
            group=DRAWING,
            row="share that is drawn close enough to its shape",
            ranked=False,
            tolerance=Tolerance(
                "path", "{value} of the line is drawn close enough to its shape, {bound} commanded"
            ),
        ),
        "strokes_missed": Score(
            "Strokes that are not drawn, are drawn to and fro, or are farther from their shape than their "
            "corners and bows allow",
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
    """Time of a drawing's lifts until the pen should be back, and of touch within it."""
    log = run.log
    if "reference_line" not in log or not reference_line(log):
        return {"time": np.nan, "touch_time": np.nan}
    away, step = held_off(log), spacing(log.time.values)
    touch = step * float((away & in_contact(log)).sum())
    return {"time": step * float(away.sum()), "touch_time": touch}
