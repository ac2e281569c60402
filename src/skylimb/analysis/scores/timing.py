"""Whether the pen was where it was to be at each moment, and how long the flight took.

A line may be drawn well at another time than it was commanded. A controller may stop the mission's clock, and
its reference waits with it: that shows in the time that it took and in its pace. What the clock does not wait
for shows in how far the pen is from its reference of the moment.
"""

from __future__ import annotations

import json

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.fit import Allowed, extent
from skylimb.analysis.scores.pen_line import in_plane, reference_line
from skylimb.analysis.scores.score import TIMING, Score, Tolerance, metric
from skylimb.analysis.scores.signals import NoNumberError, in_phase, recorded

PART = 0.95
"""Share of the sliding period in which the pen is no farther from its reference than the score says."""


def _allowed(run: Run) -> float:
    """How far the pen may be from it, for the size of its strokes, m."""
    allowed = Allowed.stated(json.loads(run.log.attrs.get("tolerances", "{}")))
    strokes = reference_line(run.log)
    if not strokes:
        return allowed.behind
    lengths = [float(np.linalg.norm(np.diff(stroke, axis=0), axis=1).sum()) for stroke in strokes]
    return allowed.behind_of(float(np.average([extent([stroke]) for stroke in strokes], weights=lengths)))


@metric(
    unit="m",
    smaller_is_better=True,
    group=TIMING,
    row=f"pen from where it should be at each moment, {100.0 * PART:g} % quantile",
    ranked=False,
    meaning=f"Distance of the pen from where it should be at each moment, {100.0 * PART:g} % quantile",
    tolerance=Tolerance(
        "behind",
        f"the pen is within {{value}} of where it should be for {100.0 * PART:g} % of the time, "
        "{bound} allowed",
        scaled=_allowed,
        required=lambda run: (
            {"tip_position", "tip_position_reference"} <= set(run.log.variables)
            and bool(in_phase(run.log, "slide").any())
        ),
    ),
)
def pen_behind(run: Run) -> float:
    """Along the sliding axes of the moment, in touch or not; how far the surface is nobody knew before."""
    sliding = np.flatnonzero(in_phase(run.log, "slide"))
    pen, wanted = (
        in_plane(run.log, recorded(run.log, name), sliding)
        for name in ("tip_position", "tip_position_reference")
    )
    away = np.linalg.norm(pen - wanted, axis=1)
    away = away[np.isfinite(away)]
    return float(np.quantile(away, PART)) if len(away) else np.nan


@metric(
    keys={
        "duration": Score(
            "Time that the sliding period took, lifts included",
            "s",
            smaller_is_better=True,
            group=TIMING,
            row="duration of the sliding period",
            ranked=False,
            name="duration",
        ),
        "pace": Score(
            "Mean pace of the mission's clock over the sliding period",
            group=TIMING,
            row="mean pace of the mission's clock",
            ranked=False,
            name="pace_mean",
        ),
    }
)
def time_taken(run: Run) -> dict[str, float]:
    """From the first to the last moment of sliding; without a controller that sets the pace it is 1."""
    time, sliding = run.log.time.values, np.flatnonzero(in_phase(run.log, "slide"))
    first, last = sliding[[0, -1]]
    duration = float(time[last] - time[first])
    try:
        clock = recorded(run.log, "mission_time")
    except NoNumberError:
        return {"duration": duration, "pace": 1.0}
    return {"duration": duration, "pace": float(clock[last] - clock[first]) / max(duration, 1e-9)}
