"""The scores of live flights as a table, in the words and units of the reports."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from skylimb.analysis.recording import Run
from skylimb.analysis.scores.axis_names import common_names
from skylimb.analysis.scores.declared import shown_scores
from skylimb.analysis.scores.user_scores import scored
from skylimb.apps.studio.live_flight import LiveFlight
from skylimb.flight.simulated_run import simulated_run


def score_table(flights: Mapping[str, LiveFlight]) -> dict[str, Any]:
    """The scores so far of some flights by their names, ready for JSON; some 0.1 s of work.

    They are those of the part that was flown: of another, easier task than the whole.

    Returns:
        `flights`, the names; `groups`, each with its `title` and `rows`, each of those with `label`, `unit`
        and one text a flight, `values`; `missed`, what flights that came to their end did not do as
        commanded, by their names.
    """
    runs = [_scored(flight) for flight in flights.values()]
    judged = [(name, run) for (name, flight), run in zip(flights.items(), runs, strict=True) if flight.over]
    missed = {name: run.missed for name, run in judged if run.missed and not run.failed}
    axes = common_names(run.log for run in runs)
    groups = []
    for title, part in shown_scores(runs).items():
        rows = []
        for score in part:
            values = [score.printed(run.metrics.get(score.name)) for run in runs]
            rows.append({"label": score.line(axes), "unit": score.unit, "values": values})
        groups.append({"title": title, "rows": rows})
    return {"flights": list(flights), "groups": groups, "missed": missed}


def _scored(flight: LiveFlight) -> Run:
    so_far = flight.flight()
    if not flight.over:  # that it was stopped here is no fault of it
        so_far = type(so_far)(so_far.signals, so_far.layout, so_far.ticks, "")
    return scored(simulated_run(flight.takeoff, so_far), flight.takeoff.own)
