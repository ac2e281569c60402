"""How the body flew: where its centre of gravity was over the sliding period, and how far it tilted.

Every controller is held to the mission: the reference of the centre of gravity is `cog_position_reference`.
A controller that leads it elsewhere on purpose, so that the pen keeps to its line, logs that place as
`cog_position_target`. How well it does so has scores of its own, which begin with `target_`. They compare
nothing between controllers.
"""

from __future__ import annotations

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.score import CONTACT, MISSION, TARGET, Score, metric
from skylimb.analysis.scores.signals import contact_axis, sliding_axes, while_sliding


def _mission(meaning: str, name: str, row: str) -> Score:
    return Score(meaning, "m", smaller_is_better=True, group=MISSION, row=row, name=name)


def _target(axis: str) -> Score:
    text = f"Median |{axis} error| of the CoG to the law's own target"
    return Score(text, "m", smaller_is_better=True, group=TARGET, row=f"|{axis} error|, median", ranked=False)


@metric(
    keys={
        "u": _mission(
            "Median |{u} error| of the CoG to the mission", "error_u_median", "|{u} error|, median"
        ),
        "v": _mission(
            "Median |{v} error| of the CoG to the mission", "error_v_median", "|{v} error|, median"
        ),
        "n": _mission(
            "Median |{n} displacement| of the CoG from the mission",
            "displacement_median",
            "|{n} displacement|, median",
        ),
    }
)
def error(run: Run) -> dict[str, float]:
    """How far the centre of gravity is from the mission's reference along the axes of the task."""
    return dict(zip("uvn", _median_off(run, "cog_position_reference"), strict=True))


@metric(keys={"u_median": _target("{u}"), "v_median": _target("{v}"), "contact_median": _target("{n}")})
def target_error(run: Run) -> dict[str, float]:
    """How far the centre of gravity is from the control law's own target along the axes of the task."""
    off = _median_off(run, "cog_position_target")
    return dict(zip(("u_median", "v_median", "contact_median"), off, strict=True))


def _median_off(run: Run, reference: str) -> list[float]:
    """Median of the distance along both sliding axes and the contact axis, m."""
    off = while_sliding(run.log, "cog_position") - while_sliding(run.log, reference)
    axes = (*sliding_axes(run.log), contact_axis(run.log))
    return [float(np.median(np.abs(axis.along(off)))) for axis in axes]


@metric(unit="rad", smaller_is_better=True, group=CONTACT, row="largest tilt")
def tilt_max(run: Run) -> float:
    """Largest tilt."""
    return float(np.max(while_sliding(run.log, "tilt")))
