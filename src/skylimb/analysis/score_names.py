"""What scores are called: their groups in a table, their words, their units, and how they are printed."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any

from skylimb.analysis.axis_names import GENERIC, AxisNames
from skylimb.analysis.force import FORCE_WINDOW
from skylimb.analysis.own import KNOWN

PEAK_WINDOW = 0.010
"""Seconds over which the force is averaged before its peak is taken:

a single sample of a stiff contact says little.
"""

LOSS_TIME = 0.050
"""Seconds without touch that count as a loss; a pen that skips over a rough patch is not lost."""

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
    "The task": ("valve_left", "peg_left", "foot_angle_mean"),
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
    "valve_left": ("Turn that the valve lacks of its stop in the end", "rad"),
    "peg_left": ("Greatest distance of the peg's end from the floor over the last 5 s of sliding", "m"),
    "foot_angle_mean": ("Mean angle between foot and surface over the last 5 s of sliding", "rad"),
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
    "valve_left": "turn that the valve lacks of its stop in the end",
    "peg_left": "peg's end from the floor, greatest over the last 5 s",
    "foot_angle_mean": "foot from lying flat, mean over the last 5 s",
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
