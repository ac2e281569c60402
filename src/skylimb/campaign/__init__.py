"""Many flights: what varies, a queue that survives kills, a table, and what the table says.

    from skylimb.campaign import run_campaign

    if __name__ == "__main__":  # worker processes import this file
        outcome = run_campaign("campaign.toml", "out/campaign")

How a campaign runs, from top to bottom:

    campaign.toml
        | reading, spec, distributions        every key checked
        v
    CampaignSpec
        | frozen                              experiment, presets and versions resolved; spec.toml
        v
    Campaign ----> draws                      draw i: a pure function of spec and i
        |
        | fly_campaign: jobs of all draws     tuning: jobs of the gains that a search tries
        v                                         |
    flight_queue <--------------------------------+
        |   ^                     jobs out, rows and logs back; a dead worker's jobs fly again
        v   |
    engines: inline | local processes | cluster (Dask) | slurm
        |   ^
        v   |
    bench.fly_jobs                            in the worker: one job -> one row
    ...
    store                                     flights.sqlite while it flies, flights.parquet at the end
        | statistics, stopping                enough? else the next jobs
        v
    summary -> summary.json, report -> report.html

The names below are loaded when they are first used, so that a worker doesn't import what draws the report.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from skylimb.campaign.flight_queue import Progress
    from skylimb.campaign.fly_campaign import Outcome, report_campaign, run_campaign
    from skylimb.campaign.reading import load_spec
    from skylimb.campaign.spec import CampaignSpec
    from skylimb.campaign.tuning.tune_gains import tune
    from skylimb.campaign.tuning.verdict import TuneOutcome

_HOME = {
    "CampaignSpec": "skylimb.campaign.spec",
    "Outcome": "skylimb.campaign.fly_campaign",
    "Progress": "skylimb.campaign.flight_queue",
    "TuneOutcome": "skylimb.campaign.tuning.verdict",
    "load_spec": "skylimb.campaign.reading",
    "report_campaign": "skylimb.campaign.fly_campaign",
    "run_campaign": "skylimb.campaign.fly_campaign",
    "tune": "skylimb.campaign.tuning.tune_gains",
}

__all__ = [
    "CampaignSpec",
    "Outcome",
    "Progress",
    "TuneOutcome",
    "load_spec",
    "report_campaign",
    "run_campaign",
    "tune",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'skylimb.campaign' has no attribute '{name}'")
    value = getattr(importlib.import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
