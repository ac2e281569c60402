"""Further numbers of a flight, in named sets, for whoever needs more than the figures of merit.

The set "paper" holds what the sentences of the paper's results section need beyond its printed medians: how
widely force and error are distributed, and what the pen drew.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from skylimb.analysis.axis_names import GENERIC, AxisNames
from skylimb.analysis.board import nominal_path
from skylimb.analysis.force import FORCE_WINDOW
from skylimb.analysis.own import KNOWN
from skylimb.analysis.score_names import DESCRIPTIONS, ROWS, description
from skylimb.analysis.signals import contact_axis, in_contact, in_phase, moving_mean, sliding_axes
from skylimb.recording import Run


@dataclass(frozen=True)
class Measures:
    """A set of numbers.

    Attributes:
        descriptions: key -> what it is, with places for the axes' names (`AxisNames.label`), and its unit.
        of: the numbers of a finished flight's log; those that it cannot tell are left out.
    """

    descriptions: dict[str, tuple[str, str]]
    of: Callable[[xr.Dataset], dict[str, float]]

    @property
    def keys(self) -> tuple[str, ...]:
        """Names, in order."""
        return tuple(self.descriptions)


def measured(run: Run, sets: Sequence[str]) -> dict[str, float | None]:
    """The numbers of some sets; None where a flight was lost or its log cannot tell.

    Args:
        run: a flight.
        sets: names in `SETS`.
    """
    found: dict[str, float | None] = {}
    for name in sets:
        values = {} if run.failed else SETS[name].of(run.log)
        for key in SETS[name].keys:
            value = values.get(key, np.nan)
            found[key] = float(value) if np.isfinite(value) else None
    return found


def describe(key: str, axes: AxisNames = GENERIC) -> tuple[str, str]:
    """What a metric or measure is for a task with these axes, and its unit."""
    if key in DESCRIPTIONS or key in KNOWN:
        return description(key, axes)
    for each in SETS.values():
        if key in each.descriptions:
            text, unit = each.descriptions[key]
            return axes.label(text), unit
    return key, "1"


def row_label(key: str, axes: AxisNames = GENERIC) -> tuple[str, str]:
    """What a number is called in a table that is divided as by `groups_of`, and its unit; empty for none."""
    text, unit = describe(key, axes)
    return axes.label(ROWS[key]) if key in ROWS else text or key, "" if unit == "1" else unit


def quartile_distance(values: np.ndarray) -> float:
    """Distance between the quartiles, the height of a box plot's box; NaN without values."""
    return float(np.subtract(*np.percentile(values, [75, 25]))) if values.size else float("nan")


def paper_measures(log: xr.Dataset) -> dict[str, float]:
    """See `PAPER`; all over the sliding period, and the pen's over the part of it in touch."""
    sliding = in_phase(log, "slide")
    if not sliding.any():
        return {}
    first = sliding_axes(log)[0]
    force = contact_axis(log).along(log.external_force_estimate.values[sliding])
    error = first.along((log.cog_position - log.cog_position_reference).values[sliding])
    reach = log.reach.values[sliding]
    return {
        "estimated_force_spread": quartile_distance(force),
        "error_u_spread": quartile_distance(np.abs(error)),
        "reach_span": float(np.subtract(*np.percentile(reach, [95, 5]))),
        **_drawn(log, sliding & in_contact(log), sliding),
    }


def _drawn(log: xr.Dataset, touching: np.ndarray, sliding: np.ndarray) -> dict[str, float]:
    """What the pen drew, seen along the contact axis, where the desired path is a circle."""
    if np.count_nonzero(touching) < 10:
        return {}

    def seen(points: np.ndarray) -> np.ndarray:
        return np.stack([axis.along(points) for axis in sliding_axes(log)], axis=1)

    wanted, drawn = seen(nominal_path(log, None)), seen(log.tip_position.values[touching])
    middle = (wanted.max(axis=0) + wanted.min(axis=0)) / 2.0
    radius = float(np.ptp(wanted, axis=0).mean()) / 2.0
    own_middle, own_radius = fitted_circle(drawn)
    slip = log.slip_speed.values[sliding]
    slip = np.where(np.isfinite(slip), slip, 0.0)
    return {
        "trace_distance": float(np.median(np.abs(np.linalg.norm(drawn - middle, axis=1) - radius))),
        "trace_size": float(np.ptp(drawn, axis=0).mean()) / (2.0 * radius),
        "trace_distortion": float(
            np.sqrt(np.mean((np.linalg.norm(drawn - own_middle, axis=1) - own_radius) ** 2)) / own_radius
        ),
        "slip_variation": float(np.std(slip) / np.mean(slip)) if np.mean(slip) > 0.0 else float("nan"),
    }


def fitted_circle(points: np.ndarray) -> tuple[np.ndarray, float]:
    """Centre and radius of the circle that fits points best (algebraic least squares).

    Args:
        points: (n, 2).
    """
    shift = points.mean(axis=0)
    moved = points - shift
    columns = np.column_stack([2.0 * moved, np.ones(len(moved))])
    (a, b, c), *_ = np.linalg.lstsq(columns, (moved**2).sum(axis=1), rcond=None)
    return shift + np.array([a, b]), float(np.sqrt(max(c + a * a + b * b, 0.0)))


def contact_measures(log: xr.Dataset) -> dict[str, float]:
    """See `SETS`; over the sliding period."""
    sliding = in_phase(log, "slide")
    if not sliding.any():
        return {}
    time = log.time.values[sliding]
    force = moving_mean(time, log.contact_force_normal.values[sliding], FORCE_WINDOW)
    along = contact_axis(log).along(log.cog_position.values[sliding])
    found = {
        "force_slow_std": float(np.std(force)),
        "near_fraction": float(np.mean(log.surface_gap.values[sliding] < NEAR)),
        "cog_travel": float(np.ptp(along)),
        "flight_time": float(log.time.values[-1]),
    }
    return found


NEAR = 0.003
"""Gap between tip and surface below which the pen still writes, m."""

SETS = {
    "contact": Measures(
        {
            "force_slow_std": (f"Standard deviation of the {FORCE_WINDOW:g} s mean of the normal force", "N"),
            "near_fraction": (
                f"Fraction of the time with the tip within {1e3 * NEAR:g} mm of the surface",
                "1",
            ),
            "cog_travel": ("Way of the centre of gravity along the contact axis, peak to peak", "m"),
            "flight_time": ("Length of the flight", "s"),
        },
        contact_measures,
    ),
    "paper": Measures(
        {
            "estimated_force_spread": (
                "Distance between the quartiles of the estimated force in {signed}",
                "N",
            ),
            "error_u_spread": (
                "Distance between the quartiles of the |{u} error| of the CoG to the mission",
                "m",
            ),
            "reach_span": ("Span of the arm's reach (5 to 95 % of the time)", "m"),
            "trace_distance": ("Median distance of the pen's trace from the desired circle", "m"),
            "trace_size": ("Width and height of the pen's trace over those of the desired circle", "1"),
            "trace_distortion": ("Departure of the pen's trace from its best circle, over the radius", "1"),
            "slip_variation": ("Standard deviation of the pen's speed over its mean", "1"),
        },
        paper_measures,
    ),
}
"""By name."""
