"""Further numbers of a flight, which a campaign computes where its `measures` names their set.

The set "paper" holds what the sentences of the paper's results section need beyond its printed medians: how
widely force and error are distributed, and what the pen drew. The set "contact" is of steady contact.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.board import nominal_path
from skylimb.analysis.scores.force import FORCE_WINDOW
from skylimb.analysis.scores.score import Score, metric
from skylimb.analysis.scores.signals import (
    contact_axis,
    held_means,
    in_contact,
    in_phase,
    recorded,
    sliding_axes,
    while_sliding,
)

NEAR = 0.003
"""Gap between tip and surface below which the pen still writes, m."""

_contact = partial(metric, on_demand="contact", ranked=False)
_paper = partial(metric, on_demand="paper", ranked=False)


@_contact(
    unit="N",
    smaller_is_better=True,
    meaning=f"Standard deviation of the {FORCE_WINDOW:g} s mean of the normal force",
)
def force_slow_std(run: Run) -> float:
    """How much the normal force swings."""
    sliding, force = in_phase(run.log, "slide"), recorded(run.log, "contact_force_normal")
    return float(np.std(held_means(run.log.time.values, force, sliding, FORCE_WINDOW)))


@_contact(
    smaller_is_better=False,
    meaning=f"Fraction of the time with the tip within {1e3 * NEAR:g} mm of the surface",
)
def near_fraction(run: Run) -> float:
    """How long the pen can write."""
    return float(np.mean(while_sliding(run.log, "surface_gap") < NEAR))


@_contact(unit="m")
def cog_travel(run: Run) -> float:
    """Way of the centre of gravity along the contact axis, peak to peak."""
    return float(np.ptp(contact_axis(run.log).along(while_sliding(run.log, "cog_position"))))


@_contact(unit="s")
def flight_time(run: Run) -> float:
    """Length of the flight."""
    return float(run.log.time.values[-1])


def quartile_distance(values: np.ndarray) -> float:
    """Distance between the quartiles, the height of a box plot's box; NaN without values."""
    return float(np.subtract(*np.percentile(values, [75, 25]))) if values.size else float("nan")


@_paper(unit="N", smaller_is_better=True)
def estimated_force_spread(run: Run) -> float:
    """Distance between the quartiles of the estimated force in {signed}."""
    force = while_sliding(run.log, "external_force_estimate")
    return quartile_distance(contact_axis(run.log).along(force))


@_paper(unit="m", smaller_is_better=True)
def error_u_spread(run: Run) -> float:
    """Distance between the quartiles of the |{u} error| of the CoG to the mission."""
    off = while_sliding(run.log, "cog_position") - while_sliding(run.log, "cog_position_reference")
    return quartile_distance(np.abs(sliding_axes(run.log)[0].along(off)))


@_paper(unit="m")
def reach_span(run: Run) -> float:
    """Span of the arm's reach (5 to 95 % of the time)."""
    return float(np.subtract(*np.percentile(while_sliding(run.log, "reach"), [95, 5])))


@metric(
    on_demand="paper",
    keys={
        "distance": Score(
            "Median distance of the pen's trace from the desired circle", "m", True, ranked=False
        ),
        "size": Score("Width and height of the pen's trace over those of the desired circle"),
        "distortion": Score(
            "Departure of the pen's trace from its best circle, over the radius", "", True, ranked=False
        ),
    },
)
def trace(run: Run) -> dict[str, float]:
    """What the pen drew, seen along the contact axis, where the desired path is a circle."""
    log, touching = run.log, _drawing(run)
    touching &= np.isfinite(recorded(log, "tip_position")).all(axis=1)
    if np.count_nonzero(touching) < _FEW:
        return dict.fromkeys(("distance", "size", "distortion"), np.nan)

    def seen(points: np.ndarray) -> np.ndarray:
        return np.stack([axis.along(points) for axis in sliding_axes(log)], axis=1)

    wanted, drawn = seen(nominal_path(log, None)), seen(log.tip_position.values[touching])
    middle = (wanted.max(axis=0) + wanted.min(axis=0)) / 2.0
    radius = float(np.ptp(wanted, axis=0).mean()) / 2.0
    own_middle, own_radius = fitted_circle(drawn)
    return {
        "distance": float(np.median(np.abs(np.linalg.norm(drawn - middle, axis=1) - radius))),
        "size": float(np.ptp(drawn, axis=0).mean()) / (2.0 * radius) if radius else np.nan,
        "distortion": float(
            np.sqrt(np.mean((np.linalg.norm(drawn - own_middle, axis=1) - own_radius) ** 2)) / own_radius
        ),
    }


@_paper(smaller_is_better=True)
def slip_variation(run: Run) -> float:
    """Standard deviation of the pen's speed over its mean."""
    slip = while_sliding(run.log, "slip_speed")
    if np.count_nonzero(_drawing(run)) < _FEW:
        return np.nan
    slip = np.where(np.isfinite(slip), slip, 0.0)
    return float(np.std(slip) / np.mean(slip)) if np.mean(slip) > 0.0 else np.nan


_FEW = 10
"""Samples in touch below which nothing was drawn."""


def _drawing(run: Run) -> np.ndarray:
    """At which samples the pen draws, (time,)."""
    return in_phase(run.log, "slide") & in_contact(run.log)


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
