"""The figures of merit of one flight, over its sliding period.

Every controller is held to the mission: the reference of the centre of gravity is
`cog_position_reference`, that of the pen is its reference line. A controller that leads the centre of gravity
elsewhere on purpose, so that the pen keeps to its line, logs that place as `cog_position_target`. How well it
does so has scores of its own, which begin with `target_`. They compare nothing between controllers.

A flight that failed is not scored: its numbers would be those of a shorter, easier task.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from skylimb.analysis.drawn_strokes import Drawn, drawn_strokes
from skylimb.analysis.force import force_limits, force_scores
from skylimb.analysis.pen_line import pen_line
from skylimb.analysis.score_names import LOSS_TIME, NUMERIC_KEYS, PEAK_WINDOW
from skylimb.analysis.signals import (
    contact_axis,
    in_contact,
    in_phase,
    moving_mean,
    sliding_axes,
    spans,
)
from skylimb.analysis.task import task_scores
from skylimb.analysis.verdict import verdict

TOUCH_TIME = 1.0
"""Seconds from the first touch on that count as the touch."""

_SCORED = (
    "cog_position",
    "cog_position_reference",
    "cog_position_target",
    "external_force_estimate",
    "contact_force_normal",
    "contact_duty",
    "contact",
    "tilt",
)


def metrics(log: xr.Dataset) -> dict[str, Any]:
    """The figures of merit over the sliding period (phase "slide"), in SI.

    Args:
        log: a run's log; the contact direction and the sliding directions come from its attributes
            `contact_axis` and `sliding_axes` (x, and y and z, where it doesn't say).

    Returns:
        `status` and the `NUMERIC_KEYS`: whether it was done as commanded (true, false, None where nothing was
        commanded that could be judged); medians of |cog_position - cog_position_reference| along the sliding
        axes and the contact axis (m); the same against `cog_position_target`; distance of the pen from its
        reference line (m); the median estimated external force along the contact axis (N, negative when the
        surface pushes); mean, standard deviation and peak of the true normal contact force (N), and its error
        against the commanded force; the fraction of the time in touch; and the largest tilt (rad). A number
        is None where the log lacks its signal or has no sliding period. A failed flight has `status`,
        `cause` and no numbers.

        Besides: `missed`, what was not done as commanded, in words; `checks`, value and tolerance of each
        thing that was; `force_limits`, what limited a commanded force (`skylimb.analysis.force`);
        and of a drawing `strokes`, each by itself (`skylimb.analysis.drawn_strokes`).
    """
    status = str(log.attrs.get("status", "OK"))
    if status != "OK":
        lost = {"status": status, "cause": str(log.attrs.get("cause", "")), **dict.fromkeys(NUMERIC_KEYS)}
        return {**lost, **_judged(log, lost), "strokes": []}
    # Only what is scored is cut out: a log holds many more signals.
    scored = log[[name for name in _SCORED if name in log.variables]]
    slide = scored.isel(time=np.flatnonzero(in_phase(log, "slide")))
    found = (
        _scores(slide) | _pen_scores(log) | force_scores(log) | task_scores(log)
        if slide.sizes["time"]
        else {}
    )
    drawn = drawn_strokes(log) if slide.sizes["time"] and "reference_line" in log else None
    if drawn is not None:
        found |= _drawing_scores(drawn)
    scores = {"status": status, **{key: _number(found.get(key)) for key in NUMERIC_KEYS}}
    strokes = drawn.strokes if drawn else ()
    each = [{name: _number(value) for name, value in stroke._asdict().items()} for stroke in strokes]
    return {**scores, **_judged(log, scores), "strokes": each}


def _drawing_scores(drawn: Drawn) -> dict[str, float]:
    whole = drawn.whole
    return {
        "line_frechet": whole.frechet,
        "line_missing_max": whole.missing,
        "line_length": whole.length,
        "line_length_drawn": whole.drawn,
        "lift_time": drawn.lift_time,
        "lift_touch_time": drawn.lift_touch,
    }


def _judged(log: xr.Dataset, scores: Mapping[str, Any]) -> dict[str, Any]:
    """The flight's verdict, and what it rests on."""
    limits = {} if scores["status"] != "OK" else force_limits(log)
    done, missed, checks = verdict(log, scores, limits)
    return {
        "done": done,
        "missed": list(missed),
        "checks": {
            check.name: {"value": check.value, "tolerance": check.tolerance, "kept": check.kept}
            for check in checks
        },
        "force_limits": limits,
    }


_COG_ERRORS = {
    "cog_position_reference": ("error_u_median", "error_v_median", "displacement_median"),
    "cog_position_target": ("target_error_u_median", "target_error_v_median", "target_error_contact_median"),
}
"""Signal that the centre of gravity is compared with, and the scores along both sliding axes and contact."""


def _scores(slide: xr.Dataset) -> dict[str, float]:
    first, second = sliding_axes(slide)
    contact = contact_axis(slide)
    scores: dict[str, float] = {}
    for signal, keys in _COG_ERRORS.items():
        if {"cog_position", signal} <= set(slide.variables):
            away = slide.cog_position.values - slide[signal].values
            for key, axis in zip(keys, (first, second, contact), strict=True):
                scores[key] = float(np.median(np.abs(axis.along(away))))
    if "external_force_estimate" in slide:
        scores["estimated_force_median"] = float(
            np.median(contact.along(slide.external_force_estimate.values))
        )
    if "contact_force_normal" in slide:
        force = slide.contact_force_normal.values
        scores["contact_force_normal_mean"] = float(np.mean(force))
        scores["contact_force_normal_std"] = float(np.std(force))
        scores["contact_force_normal_peak"] = float(
            np.max(moving_mean(slide.time.values, force, PEAK_WINDOW))
        )
    # The duty counts physics steps and so does not depend on the control rate; the flag says "any touch in
    # the tick".
    touch = next((name for name in ("contact_duty", "contact") if name in slide), None)
    if touch:
        scores["contact_fraction"] = float(np.mean(slide[touch].values.astype(float)))
    if "tilt" in slide:
        scores["tilt_max"] = float(np.max(slide.tilt))
    return scores


def _pen_scores(log: xr.Dataset) -> dict[str, float]:
    """Line, losses and first touch of the pen."""
    rms, most = pen_line(log)
    scores = {"pen_line_rms": rms, "pen_line_max": most}
    sliding = in_phase(log, "slide")
    time = log.time.values
    if "contact_duty" in log or "contact" in log:
        touching = np.flatnonzero(in_contact(log))
        # What was never touched cannot be lost.
        touched = time[touching[0]] if len(touching) else np.inf
        gaps = spans(time, ~in_contact(log) & sliding, 0.0)
        lost = [begin > touched and end - begin > LOSS_TIME for begin, end in gaps]
        scores["contact_losses"] = float(sum(lost))
        if len(touching) and "contact_force_normal" in log:
            first = (time >= time[touching[0]]) & (time < time[touching[0]] + TOUCH_TIME)
            force = log.contact_force_normal.values[first]
            scores["touch_force_peak"] = float(np.max(moving_mean(time[first], force, PEAK_WINDOW)))
    return scores


def _number(value: float | None) -> float | None:
    """None stands for "not known" in the JSON file, where NaN is no number at all."""
    return value if value is not None and np.isfinite(value) else None
