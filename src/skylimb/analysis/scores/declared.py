"""The declarations that a record carries: those of the scores of a user's own, which stand in no module here.

A run is shown and judged by them wherever it is read, without the file that computed them.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, replace
from typing import TYPE_CHECKING

from skylimb.analysis.recording.run import AnyRun, Run
from skylimb.analysis.scores.registry import SCORES
from skylimb.analysis.scores.score import Score, Tolerance, grouped

if TYPE_CHECKING:
    import xarray as xr

ATTRIBUTE = "scores"
"""Of a log: JSON, a list with the fields of each `Score`."""


def declared_in(log: xr.Dataset) -> dict[str, Score]:
    """The declarations of a user's own scores in a log, by name."""
    found = {}
    for fields in json.loads(log.attrs.get(ATTRIBUTE, "[]")):
        tolerance = fields.pop("tolerance")
        found[fields["name"]] = Score(**fields, tolerance=Tolerance(**tolerance) if tolerance else None)
    return found


def declaring(run: AnyRun, scores: Iterable[Score]) -> AnyRun:
    """The run with more declarations in its log; its tolerances have the words that suit this run."""
    found = declared_in(run.log)
    for score in scores:
        found[score.name] = replace(score, tolerance=_judging(run, score))
    if not found:
        return run
    text = json.dumps([asdict(score) for score in found.values()])
    return replace(run, log=run.log.assign_attrs({ATTRIBUTE: text}))


def _judging(run: Run, score: Score) -> Tolerance | None:
    """The tolerance with what it is for this run; None where the score is not judged."""
    tolerance = score.tolerance
    if tolerance is None or run.metrics.get(score.name) is not None:
        return tolerance and tolerance.of(run)
    return Tolerance(tolerance.bound, required=True) if tolerance.is_required(run) else None


def scores_of(runs: Iterable[Run]) -> Mapping[str, Score]:
    """The declaration of every score that some runs may have: the shipped ones, and those that they carry."""
    return {**SCORES, **{name: score for run in runs for name, score in declared_in(run.log).items()}}


def shown_scores(runs: Iterable[Run]) -> dict[str, list[Score]]:
    """The scores that any of some runs has, as tables show them (`grouped`)."""
    flown = list(runs)
    known = scores_of(flown).values()
    return grouped(score for score in known if any(run.metrics.get(score.name) is not None for run in flown))
