"""Which wanted forces the presets `following` and `drawing` keep, beside what the model can hold.

    python benchmarks/forces.py [--minutes 60] [--tables]

The paper's circle on boards of five slopes and four frictions, six wanted forces, two seeds for each preset:
480 flights. docs/forces.json keeps every one, a line each; one that it holds is not flown again. The table
between the markers of docs/reports/scores.md is written anew: flights by the share of the wanted force in
what `flights.held` holds against slope and drag.
"""

from __future__ import annotations

import argparse
import itertools
import json
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from following import scored  # beside this file
from kept import fill, keep

from skylimb.control.controller import load_controller
from skylimb.control.needs import needs_of
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.experiments.experiment import Experiment, load_experiment
from skylimb.flight.feasible import pressed_against_drag
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import prepare
from skylimb.robots.loader import load_robot

DOCS = Path(__file__).parents[1] / "docs"
PAGE, NUMBERS = DOCS / "reports" / "scores.md", DOCS / "forces.json"
PRESETS = ("following", "drawing")
SLOPES, FRICTIONS = (20, -20, 0, 14, -14), (0.2, 0.4, 0.6, 0.8)
FORCES, SEEDS = (0.5, 1.0, 2.0, 3.0, 4.0, 5.0), (0, 1)
SCORES = {"mean": "contact_force_normal_mean", "std": "contact_force_normal_std", "touch": "contact_fraction"}
EDGES = (0.0, 0.25, 0.4, 0.5, 0.6, 0.8, 1.0, np.inf)
MOST = 20.0
"""The model is asked for no more than this, N."""
TOGETHER = len(FORCES) * len(SEEDS)


def cells() -> list[dict[str, Any]]:
    """Preset, slope (degrees), friction, wanted force (N) and seed of every flight."""
    names = ("preset", "slope", "friction", "force", "seed")
    every = itertools.product(PRESETS, SLOPES, FRICTIONS, FORCES, SEEDS)
    return [dict(zip(names, cell, strict=True)) for cell in every]


def experiment_of(cell: Mapping[str, Any]) -> Experiment:
    """The paper's circle on the cell's board, its force held to a tenth, or to 0.1 N where that is more."""
    board = {"surface.slope": float(np.radians(cell["slope"])), "surface.friction": cell["friction"]}
    tolerance = {"tolerances.force": max(0.1, 0.1 / cell["force"]), "approach.doubtful": "fly"}
    return load_experiment("paper", {**board, **tolerance, "seed": cell["seed"]})


def flown(some: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The cells with what the model holds there, and what the flights did."""
    robot = load_robot("hydrus_xi_quad")
    ready = [
        prepare(
            experiment_of(cell),
            robot,
            load_controller(cell["preset"], robot, {"translation.force": cell["force"]}),
        )
        for cell in some
    ]
    rows = []
    for cell, takeoff, flight in zip(some, ready, fly_native(ready), strict=True):
        found = scored(scored_run(takeoff, flight))
        held = pressed_against_drag(
            takeoff.experiment,
            robot,
            needs_of(takeoff.controller),
            MOST,
            takeoff.experiment.surface.friction,
            abs(takeoff.experiment.surface.slope),
        ).force
        rows.append(
            {
                **cell,
                "held": held,
                "lost": found["cause"] if found["status"] != "OK" else "",
                "kept": found["checks"].get("force", {"kept": False})["kept"],
            }
            | {name: found[score] for name, score in SCORES.items()}
        )
    return rows


def table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Flights by their share of what can be held."""
    lines = [
        "| wanted over held | flights of each | `following`: lost, kept | `drawing`: lost, kept |",
        "|---|---|---|---|",
    ]
    for low, high in itertools.pairwise(EDGES):
        inside = [row for row in rows if low < row["force"] / row["held"] <= high]
        cells = []
        for preset in PRESETS:
            own = [row for row in inside if row["preset"] == preset]
            cells.append(f"{sum(bool(row['lost']) for row in own)}, {sum(row['kept'] for row in own)}")
        name = f"{low:.2f} .. {high:.2f}" if np.isfinite(high) else f"above {low:.2f}"
        lines.append(f"| {name} | {len(inside) // len(PRESETS)} | {' | '.join(cells)} |")
    return "\n".join(lines)


def main() -> None:
    """Fly what is missing, keep it, write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--minutes", type=float, default=60.0, help="begin no more flights after so long")
    parser.add_argument("--tables", action="store_true", help="fly nothing: the table of docs/forces.json")
    options = parser.parse_args()
    rows = json.loads(NUMBERS.read_text(encoding="utf-8")) if NUMBERS.exists() else []
    began, todo = time.monotonic(), [] if options.tables else cells()[len(rows) :]
    for at in range(0, len(todo), TOGETHER):
        if time.monotonic() - began > 60.0 * options.minutes:
            break
        rows += flown(todo[at : at + TOGETHER])
        keep(NUMBERS, rows)
        print(len(rows), rows[-1], flush=True)
    fill(PAGE, "forces", table(rows))
    print(table(rows))


if __name__ == "__main__":
    main()
