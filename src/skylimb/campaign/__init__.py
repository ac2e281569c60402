"""Many flights: a spec, its draws, an engine that survives, a table, and what the table says.

    from skylimb.campaign import run_campaign

    if __name__ == "__main__":  # worker processes import this file
        outcome = run_campaign("campaign.toml", "out/campaign")

The names below are loaded when they are first used, so that a worker doesn't import what draws the report.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from skylimb.campaign.coordinator import Progress
    from skylimb.campaign.reading import load_spec
    from skylimb.campaign.run import Outcome, report_campaign, run_campaign
    from skylimb.campaign.spec import CampaignSpec
    from skylimb.campaign.tuning.run import tune
    from skylimb.campaign.tuning.verdict import TuneOutcome

_HOME = {
    "CampaignSpec": "skylimb.campaign.spec",
    "Outcome": "skylimb.campaign.run",
    "Progress": "skylimb.campaign.coordinator",
    "TuneOutcome": "skylimb.campaign.tuning.verdict",
    "load_spec": "skylimb.campaign.reading",
    "report_campaign": "skylimb.campaign.run",
    "run_campaign": "skylimb.campaign.run",
    "tune": "skylimb.campaign.tuning.run",
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
