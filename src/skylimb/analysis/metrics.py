"""The figures of merit of one flight, over its sliding period.

Every controller is held to the mission: the reference of the centre of gravity is
`cog_position_reference`, that of the pen is its reference line. A controller that leads the centre of gravity
elsewhere on purpose, so that the pen keeps to its line, logs that place as `cog_position_target`. How well it
does so has scores of its own, which begin with `target_`. They compare nothing between controllers.

A flight that failed is not scored: its numbers would be those of a shorter, easier task.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from skylimb.analysis.axis_names import GENERIC, AxisNames
from skylimb.analysis.drawn_strokes import Drawn, drawn_strokes
from skylimb.analysis.force import FORCE_WINDOW, force_limits, force_scores
from skylimb.analysis.own import KNOWN
from skylimb.analysis.pen_line import pen_line
from skylimb.analysis.signals import (
    contact_axis,
    in_contact,
    in_phase,
    moving_mean,
    sliding_axes,
    spans,
)
from skylimb.analysis.verdict import verdict

PEAK_WINDOW = 0.010
"""Seconds over which the force is averaged before its peak is taken:

a single sample of a stiff contact says little.
"""

LOSS_TIME = 0.050
"""Seconds without touch that count as a loss; a pen that skips over a rough patch is not lost."""

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

GROUPS = {
    "Done as commanded": ("done",),
    "Distance of the centre of gravity from the mission's reference": (
        "error_u_median",
        "error_v_median",
        "displacement_median",
    ),
    "Distance of the centre of gravity from the control law's own target": (
        "target_error_u_median",
        "target_error_v_median",
        "target_error_contact_median",
    ),
    "Distance of the pen from its reference line": ("pen_line_rms", "pen_line_max"),
    "The drawing": (
        "line_frechet",
        "line_missing_max",
        "line_length",
        "line_length_drawn",
        "lift_time",
        "lift_touch_time",
    ),
    "Force": (
        "estimated_force_median",
        "contact_force_normal_mean",
        "contact_force_normal_std",
        "contact_force_normal_peak",
        "touch_force_peak",
        "force_error_mean",
        "force_error_percent",
        "force_error_rms",
    ),
    "Contact and attitude": ("contact_fraction", "contact_losses", "tilt_max"),
}
"""The numbers by what they measure, as tables show them."""

NUMERIC_KEYS = tuple(key for keys in GROUPS.values() for key in keys)
"""Every number that `metrics` gives, in this order.

u and v stand for the sliding axes. Displacement and force are along the contact axis.
"""

YES_OR_NO = ("done",)
"""Those that a flight does or does not; of many flights they have a rate."""

_TEXTS = {
    "done": ("Whether the flight did what was commanded, within its tolerances", "1"),
    "error_u_median": ("Median |{u} error| of the CoG to the mission", "m"),
    "error_v_median": ("Median |{v} error| of the CoG to the mission", "m"),
    "displacement_median": ("Median |{n} displacement| of the CoG from the mission", "m"),
    "target_error_u_median": ("Median |{u} error| of the CoG to the law's own target", "m"),
    "target_error_v_median": ("Median |{v} error| of the CoG to the law's own target", "m"),
    "target_error_contact_median": ("Median |{n} error| of the CoG to the law's own target", "m"),
    "pen_line_rms": ("Distance of the pen from its reference line, root mean square", "m"),
    "pen_line_max": ("Largest distance of the pen from its reference line", "m"),
    "line_frechet": ("Frechet distance between the drawn lines and their reference, in their order", "m"),
    "line_missing_max": ("Farthest that a place of the reference line is from what was drawn", "m"),
    "line_length": ("Length of the reference line", "m"),
    "line_length_drawn": ("Length of what was drawn", "m"),
    "lift_time": ("Time for which the pen was to be lifted", "s"),
    "lift_touch_time": ("Time of touch while it was to be lifted", "s"),
    "estimated_force_median": ("Median estimated force in {signed}", "N"),
    "contact_force_normal_mean": ("Mean normal contact force (truth)", "N"),
    "contact_force_normal_std": ("Standard deviation of the normal force (truth)", "N"),
    "contact_force_normal_peak": (
        f"Peak of the {1e3 * PEAK_WINDOW:g} ms mean of the normal force (truth)",
        "N",
    ),
    "touch_force_peak": (
        f"Peak of the {1e3 * PEAK_WINDOW:g} ms mean of the normal force at the first touch",
        "N",
    ),
    "force_error_mean": ("Mean error of the normal force (truth) against the commanded one", "N"),
    "force_error_percent": ("Size of that mean error, of the commanded force", "%"),
    "force_error_rms": (
        f"Root mean square error of the {FORCE_WINDOW:g} s mean of the normal force (truth)",
        "N",
    ),
    "contact_fraction": ("Fraction of the time in contact (truth)", "1"),
    "contact_losses": (f"Times that the touch was lost for longer than {1e3 * LOSS_TIME:g} ms", "1"),
    "tilt_max": ("Largest tilt", "rad"),
}
"""What each number is, with places for the axes' names (`AxisNames.label`), and its unit."""

DESCRIPTIONS = {key: (GENERIC.label(text), unit) for key, (text, unit) in _TEXTS.items()}
"""What each number is, and its unit, for a task with any axes."""


def description(key: str, axes: AxisNames = GENERIC) -> tuple[str, str]:
    """What a number of ours or of the user's is for a task with these axes, and its unit."""
    if key in KNOWN:
        return KNOWN[key].description(key)
    text, unit = _TEXTS[key]
    return axes.label(text), unit


ROWS = {
    "done": "all of it, within the tolerances",
    "error_u_median": "|{u} error|, median",
    "error_v_median": "|{v} error|, median",
    "displacement_median": "|{n} displacement|, median",
    "target_error_u_median": "|{u} error|, median",
    "target_error_v_median": "|{v} error|, median",
    "target_error_contact_median": "|{n} error|, median",
    "pen_line_rms": "root mean square",
    "pen_line_max": "largest",
    "line_frechet": "Frechet distance to its reference, in the strokes' order",
    "line_missing_max": "farthest place of the reference from what was drawn",
    "line_length": "length of the reference",
    "line_length_drawn": "length drawn",
    "lift_time": "time for which the pen was to be lifted",
    "lift_touch_time": "touch in that time",
    "estimated_force_median": "estimated in {signed}, median",
    "contact_force_normal_mean": "normal (truth), mean",
    "contact_force_normal_std": "normal (truth), standard deviation",
    "contact_force_normal_peak": f"normal (truth), peak of its {1e3 * PEAK_WINDOW:g} ms mean",
    "touch_force_peak": "the same at the first touch",
    "force_error_mean": "error against the commanded force, mean",
    "force_error_percent": "size of that mean error, of the commanded force",
    "force_error_rms": f"error of its {FORCE_WINDOW:g} s mean, root mean square",
    "contact_fraction": "fraction of the time in contact (truth)",
    "contact_losses": f"losses of touch for longer than {1e3 * LOSS_TIME:g} ms",
    "tilt_max": "largest tilt",
}
"""What each number is called in a table whose lines stand below the titles of `GROUPS`.

With places for the axes' names.
"""


def printed(key: str, value: float | None) -> str:
    """A number in a table: three places, none for a count, and a true minus sign; empty for no number.

    One flight's verdict is yes or no, that of many flights the share of yes.
    """
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    text = f"{value:g}" if key == "contact_losses" else f"{value:.3f}"
    return text.replace("-", "\N{MINUS SIGN}")


def known_groups(scores: Iterable[Mapping[str, Any]]) -> dict[str, tuple[str, ...]]:
    """`GROUPS` and the user's own numbers, without those that none of these flights has.

    Args:
        scores: as `metrics` gives them, one a flight.
    """
    flown = list(scores)
    own = dict.fromkeys(key for each in flown for key in each if key in KNOWN)
    known = [key for key in (*NUMERIC_KEYS, *own) if any(each.get(key) is not None for each in flown)]
    return groups_of(known)


def groups_of(keys: Collection[str]) -> dict[str, tuple[str, ...]]:
    """Some of the numbers by what they measure; numbers that are none of `NUMERIC_KEYS` come last."""
    kept = {title: tuple(key for key in group if key in keys) for title, group in GROUPS.items()}
    kept["Further numbers"] = tuple(key for key in keys if key not in NUMERIC_KEYS)
    return {title: group for title, group in kept.items() if group}


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
    found = _scores(slide) | _pen_scores(log) | force_scores(log) if slide.sizes["time"] else {}
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
        gaps = spans(time, ~in_contact(log) & sliding, 0.0)
        scores["contact_losses"] = float(sum(end - begin > LOSS_TIME for begin, end in gaps))
        touching = np.flatnonzero(in_contact(log))
        if len(touching) and "contact_force_normal" in log:
            first = (time >= time[touching[0]]) & (time < time[touching[0]] + TOUCH_TIME)
            force = log.contact_force_normal.values[first]
            scores["touch_force_peak"] = float(np.max(moving_mean(time[first], force, PEAK_WINDOW)))
    return scores


def _number(value: float | None) -> float | None:
    """None stands for "not known" in the JSON file, where NaN is no number at all."""
    return value if value is not None and np.isfinite(value) else None
