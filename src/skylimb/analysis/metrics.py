"""The figures of merit of one flight, over its sliding period.

The reference of every error is `cog_position_reference`. A flight that failed is not scored: its numbers
would be those of a shorter, easier task.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from skylimb.analysis.pen_line import pen_line
from skylimb.analysis.signals import contact_axis, in_contact, in_phase, sliding_axes, spans

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
    "external_force_estimate",
    "contact_force_normal",
    "contact_duty",
    "contact",
    "tilt",
)

NUMERIC_KEYS = (
    "error_y_median",
    "error_z_median",
    "displacement_x_median",
    "estimated_force_x_median",
    "contact_force_normal_mean",
    "contact_force_normal_std",
    "contact_force_normal_peak",
    "contact_fraction",
    "tilt_max",
    "pen_line_rms",
    "pen_line_max",
    "contact_losses",
    "touch_force_peak",
)
"""Every number that `metrics` gives, in this order.

y and z stand for the sliding axes, x for the contact axis.
"""

DESCRIPTIONS = {
    "error_y_median": ("Median |y error| of the CoG", "m"),
    "error_z_median": ("Median |z error| of the CoG", "m"),
    "displacement_x_median": ("Median |x displacement| of the CoG", "m"),
    "estimated_force_x_median": ("Median estimated force in x", "N"),
    "contact_force_normal_mean": ("Mean normal contact force (truth)", "N"),
    "contact_force_normal_std": ("Standard deviation of the normal force (truth)", "N"),
    "contact_force_normal_peak": ("Peak of the 10 ms mean of the normal force (truth)", "N"),
    "contact_fraction": ("Fraction of the time in contact (truth)", "1"),
    "tilt_max": ("Largest tilt", "rad"),
    "pen_line_rms": ("Distance of the drawn line from the asked one, root mean square", "m"),
    "pen_line_max": ("Largest distance of the drawn line from the asked one", "m"),
    "contact_losses": ("Times that the touch was lost for longer than 50 ms", "1"),
    "touch_force_peak": ("Peak of the 10 ms mean of the normal force at the first touch", "N"),
}
"""What each number is, and its unit."""


def metrics(log: xr.Dataset) -> dict[str, Any]:
    """The figures of merit over the sliding period (phase "slide"), in SI.

    Args:
        log: a run's log; the contact direction and the sliding directions come from its attributes
            `contact_axis` and `sliding_axes` (x, and y and z, where it doesn't say).

    Returns:
        `status` and the `NUMERIC_KEYS`: medians of |cog_position - cog_position_reference| along the sliding
        axes and the contact axis (m), the median estimated external force along the contact axis (N, negative
        when the surface pushes), mean, standard deviation and peak of the true normal contact force (N), the
        fraction of the time in touch, and the largest tilt (rad). A number is None where the log lacks its
        signal or has no sliding period. A failed flight has `status`, `cause` and no numbers.
    """
    status = str(log.attrs.get("status", "OK"))
    if status != "OK":
        return {"status": status, "cause": str(log.attrs.get("cause", "")), **dict.fromkeys(NUMERIC_KEYS)}
    # Only what is scored is cut out: a log holds many more signals.
    scored = log[[name for name in _SCORED if name in log.variables]]
    slide = scored.isel(time=np.flatnonzero(in_phase(log, "slide")))
    scores = _scores(slide) | _pen_scores(log) if slide.sizes["time"] else {}
    return {"status": status, **{key: _number(scores.get(key)) for key in NUMERIC_KEYS}}


def _scores(slide: xr.Dataset) -> dict[str, float]:
    first, second = sliding_axes(slide)
    contact = contact_axis(slide)
    scores: dict[str, float] = {}
    if {"cog_position", "cog_position_reference"} <= set(slide.variables):
        away = slide.cog_position.values - slide.cog_position_reference.values
        scores["error_y_median"] = float(np.median(np.abs(first.along(away))))
        scores["error_z_median"] = float(np.median(np.abs(second.along(away))))
        scores["displacement_x_median"] = float(np.median(np.abs(contact.along(away))))
    if "external_force_estimate" in slide:
        scores["estimated_force_x_median"] = float(
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


def moving_mean(time: np.ndarray, values: np.ndarray, window: float) -> np.ndarray:
    """Means over every stretch of `window` seconds that lies wholly inside the samples.

    Args:
        time: evenly spaced times (s), shape (n,).
        values: shape (n,).
        window: seconds; rounded to whole samples, and at least one sample.

    Returns:
        Shape (n - k + 1,) for a window of k samples.
    """
    spacing = (time[-1] - time[0]) / (len(time) - 1) if len(time) > 1 else window
    count = int(np.clip(round(window / spacing), 1, len(values)))
    total = np.cumsum(np.concatenate([[0.0], values]))
    return (total[count:] - total[:-count]) / count


def _number(value: float | None) -> float | None:
    """None stands for "not known" in the JSON file, where NaN is no number at all."""
    return value if value is not None and np.isfinite(value) else None
