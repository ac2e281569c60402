"""Every score that ships, put together from the modules that declare and compute them.

A score more is a function more in one of them; see `skylimb.analysis.scores.score`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores import (
    area,
    body,
    drawn_strokes,
    estimate,
    faults,
    force,
    measures,
    pen_line,
    task,
    timing,
    touch,
)
from skylimb.analysis.scores.score import Metric, Number, Score, grouped
from skylimb.analysis.scores.signals import in_phase
from skylimb.analysis.scores.verdict import DONE

METRICS: tuple[Metric, ...] = tuple(
    found
    for module in (
        force,
        touch,
        pen_line,
        drawn_strokes,
        timing,
        area,
        task,
        body,
        measures,
        faults,
        estimate,
    )
    for found in vars(module).values()
    if isinstance(found, Metric)
)
"""In the order in which a verdict tells of them: the press, the touch, the line."""

SCORES: Mapping[str, Score] = MappingProxyType(
    {
        score.name: score
        for part in grouped([DONE, *(score for each in METRICS for score in each.scores)]).values()
        for score in part
    }
)
"""The declaration of each by name, in the order of tables."""

SETS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        each.on_demand: tuple(
            key for one in METRICS if one.on_demand == each.on_demand for key in one.columns
        )
        for each in METRICS
        if each.on_demand
    }
)
"""The sets of further numbers, which are computed where they are asked for."""

NUMERIC_KEYS: tuple[str, ...] = tuple(
    key for key in SCORES if not any(key in columns for columns in SETS.values())
)
"""The scores of every flight, in this order.

u and v stand for the sliding axes. Displacement and force are along the contact axis.
"""

TOLERANCES = frozenset(
    score.tolerance.bound
    for score in SCORES.values()
    if score.tolerance and isinstance(score.tolerance.bound, str)
)
"""Every key of an experiment's `[tolerances]`: each is what some score is held to."""


def numbers_of(run: Run, metrics: Iterable[Metric]) -> dict[str, Number]:
    """Shipped scores of a run, over its sliding period; None without one, and mostly for a lost flight."""
    whole = not run.failed and bool(in_phase(run.log, "slide").any())
    found: dict[str, Number] = {}
    for each in metrics:
        found |= each.of(run) if whole or each.lost else dict.fromkeys(each.columns)
    return found


def measured(run: Run, sets: Iterable[str]) -> dict[str, Number]:
    """The scores of some of the `SETS`; None where a flight was lost or its log cannot tell."""
    return numbers_of(run, [each for name in sets for each in METRICS if each.on_demand == name])
