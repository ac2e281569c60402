"""Whether a flight did what it was commanded, within the tolerances that its experiment states.

A flight that comes to its end has the status OK. That says nothing of what it did there. Its verdict does:
every score that is declared with a tolerance is held to it, a user's own as well. The pen touches, keeps to
its reference line, draws all of it, and presses with the commanded force where one is commanded. What is
commanded and has no value is missed; what else has none is not judged. A flight of which nothing can be
judged, such as one that is to touch nothing, has no verdict. A flight that was lost or not finished did not
do what was commanded, whatever it did before.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.axis_names import axis_names
from skylimb.analysis.scores.score import GROUPS, Score, Tolerance

DONE = Score(
    "Whether the flight did what was commanded, within its tolerances",
    smaller_is_better=False,
    group=GROUPS[0],
    row="all of it, within the tolerances",
    kind="yes or no",
    ranked=False,
    name="done",
)
"""The verdict as a score; what gives its value are all others."""

_MORE_PLACES = 9
"""Places more, at most, with which a value is written that lies close to its bound."""


def verdict(run: Run, scores: Iterable[Score]) -> dict[str, Any]:
    """The verdict on a flight by some scores, on top of what has been judged of it.

    Args:
        run: with the values of the scores in its metrics; the attribute `tolerances` (JSON) of its log says
            what is commanded, a flight without contact has none.
        scores: those with a tolerance are judged, in this order.

    Returns:
        `done`: None where nothing could be judged, or the flight was stopped on purpose. `missed`: what was
        missed and by how much, in words. `checks`: by the tolerance's name, or the
        score's where another is held to the same: `value` (in the tolerance's unit; None where a required one
        has none), `tolerance`, and whether it is `kept`.
    """
    known = json.loads(run.log.attrs.get("tolerances", "{}"))
    missed, checks = list(run.metrics.get("missed", ())), dict(run.metrics.get("checks", {}))
    held = [
        (score, tolerance, bound)
        for score in scores
        if (tolerance := score.tolerance) and (bound := tolerance.stated(known)) is not None
    ]
    if run.failed:
        judged = bool(held) or run.metrics.get("done") is False
        words = "the flight was lost" if run.lost else "the flight was not finished"
        return {"done": False if judged else None, "missed": [words] * judged, "checks": checks}
    if run.stopped:
        return {"done": None, "missed": [], "checks": checks}
    for score, tolerated, stated in held:
        value = run.metrics.get(score.name)
        name = tolerated.bound if tolerated.bound in known and tolerated.bound not in checks else score.name
        if value is None:
            if tolerated.is_required(run):
                checks[name] = {"value": None, "tolerance": stated, "kept": False}
                missed.append(f"{score.text(axis_names(run.log))}: there is none to be judged")
            continue
        if (tolerance := tolerated.of(run)).per == 0.0:
            continue
        value = value if tolerance.per is None else value / tolerance.per
        bound = tolerated.scaled(run) if tolerated.scaled else stated
        kept = value <= bound if score.smaller_is_better else value >= bound
        checks[name] = {"value": value, "tolerance": bound, "kept": kept}
        if not kept:
            missed.append(_words(run, score, tolerance, value, bound))
    return {"done": not missed if checks else None, "missed": missed, "checks": checks}


def _words(run: Run, score: Score, tolerance: Tolerance, value: float, bound: float) -> str:
    """What was missed, and by how much."""
    unit = "" if tolerance.per is not None else "count" if score.kind == "count" else score.unit
    usual = f"{score.text(axis_names(run.log))}: {{value}}, {{bound}} " + (
        "allowed" if score.smaller_is_better else "commanded"
    )
    words = str(tolerance.words or usual)
    told, allowed = quantities(value, bound, unit)
    return words.replace("{value}", told).replace("{bound}", allowed)


def quantities(value: float, bound: float, unit: str) -> tuple[str, str]:
    """A value and its bound in the unit in which one thinks of them: mm, degrees, percent, times.

    The value has more places where rounding would hide that it misses the bound.
    """
    factor, suffix, places, kind = {
        "m": (1e3, " mm", 1, "f"),
        "rad": (float(np.degrees(1.0)), "\N{DEGREE SIGN}", 1, "f"),
        "count": (1.0, "", 6, "g"),
        "times": (1.0, " times", 1, "f"),
        "": (100.0, " %", 0, "f"),
    }.get(unit, (1.0, f" {unit}", 3, "g"))
    allowed, told = f"{factor * bound:{'.1f' if unit == 'rad' else 'g'}}", ""
    for more in range(_MORE_PLACES):
        told = f"{factor * value:.{places + more}{kind}}"
        if (float(told) - float(allowed)) * (value - bound) > 0.0:
            break
    return f"{told}{suffix}", f"{allowed}{suffix}"
