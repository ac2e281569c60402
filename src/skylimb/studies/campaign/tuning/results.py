"""What a search leaves: a preset for each controller, the verdict, and every trial."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from skylimb.base.config import write_toml
from skylimb.base.files import csv_text
from skylimb.control.controller import resolved_tables
from skylimb.flight.experiments.experiment import robot_of
from skylimb.studies.campaign.draws import changed
from skylimb.studies.campaign.frozen import Campaign
from skylimb.studies.campaign.tuning.gains import Gains
from skylimb.studies.campaign.tuning.search import Trial
from skylimb.studies.campaign.tuning.verdict import TuneOutcome

VERDICT_FILE = "verdict.json"
TRIALS_FILE = "trials.csv"


def texts(campaign: Campaign, outcome: TuneOutcome, trials: Mapping[str, Sequence[Trial]]) -> dict[str, str]:
    """File name -> content."""
    keys = list(next(iter(outcome.tuned.values())).before)
    rows = [
        [trial.controller, trial.number, repr(trial.cost), *(repr(trial.gains[key]) for key in keys)]
        for tried in trials.values()
        for trial in tried
    ]
    verdict = {
        "objective": outcome.objective.name,
        "held_out_draws": outcome.draws,
        "controllers": {
            name: {
                "rank": outcome.ranks[name],
                "better": found.better,
                "trials": found.trials,
                "before": found.before,
                "after": found.after,
                "successes": {"tuned": found.successes[0], "untuned": found.successes[1]},
                "tuned_less_untuned": {
                    key: value if np.isfinite(value) else str(value)
                    for key, value in found.held_out._asdict().items()
                },
            }
            for name, found in outcome.tuned.items()
        },
    }
    presets = {
        f"{name}.toml": write_toml(_preset(campaign, name, found.after, outcome.folder))
        for name, found in outcome.tuned.items()
    }
    return {
        **presets,
        TRIALS_FILE: csv_text([["controller", "trial", "cost", *keys], *rows]),
        VERDICT_FILE: json.dumps(verdict, indent=2, allow_nan=False) + "\n",
    }


def _preset(campaign: Campaign, name: str, gains: Gains, folder: Path) -> dict[str, Any]:
    """The tuned controller's tables; a file of the user's is named as seen from the new folder."""
    entry = campaign.controllers[name]
    if "preset" not in entry:
        robot = robot_of(campaign.experiment_of(campaign.draw(0)))
        tables = resolved_tables(campaign.load(name, robot, gains))
        file = Path(os.path.relpath(entry["path"], folder)).as_posix()
        return {**tables, "file": file, "description": f"{name}; tuned for {campaign.spec.experiment}"}
    tables = changed(entry["preset"], gains)
    for slot in tables.values():
        if isinstance(slot, dict) and str(slot.get("law", "")).endswith(".py"):
            slot["law"] = Path(os.path.relpath(Path(entry["path"]).parent / slot["law"], folder)).as_posix()
    text = str(tables.get("description", name)).rstrip(".")
    return {**tables, "description": f"{text}; tuned for {campaign.spec.experiment}"}
