"""The planned posture against the paper's, the same experiment, draws of friction, slope and noise.

    python benchmarks/planned_posture.py [--draws 100] [--controllers hybrid following]

Per draw the friction is between 0.2 and 0.6, the slope between 10 and 25 degrees as the paper's, and the
seed of the noise another (`SEED` and the draw's number). The plan is made once a controller, for the
experiment as it ships. Plans and scores are kept in out/planned_posture, so that an interrupted run goes on;
remove it after a change of the planner. The table is written into docs/reports/feasibility.md.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
from transformations import PAGE

import skylimb
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import take_off
from skylimb.studies.planning.task_plan import EXPERIMENT, plan_posture, write_planned

SEED = 7
TOGETHER = 10
KEPT = PAGE.parents[2] / "out" / "planned_posture"
MEASURES = ("contact_force_normal_std", "pen_line_rms", "contact_fraction")
BEGIN, END = "<!-- planned: written by benchmarks/planned_posture.py -->", "<!-- end of planned -->"
HEAD = (
    "| controller | posture | planned for: worst margin, N m | lost | contact kept "
    "| force spread, N: median, 90 % "
    "| pen line, mm: median, 90 % |",
    "|---|---|---|---|---|---|---|",
)


def drawn(draw: int) -> dict[str, Any]:
    """What is different in a draw."""
    rng = np.random.default_rng([SEED, draw])
    slope = np.radians(rng.uniform(10.0, 25.0))
    return {"surface.friction": float(rng.uniform(0.2, 0.6)), "surface.slope": float(slope)}


def flown(experiment: str, controller: str, draws: int, kept: Path) -> list[dict[str, Any]]:
    """The scores of every draw, kept in a file after each few flights."""
    scores = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else []
    for first in range(len(scores), draws, TOGETHER):
        seeds = range(first, min(first + TOGETHER, draws))
        some = [take_off(experiment, (controller,), seed, drawn(seed))[0] for seed in seeds]
        for takeoff, flight in zip(some, fly_native(some), strict=True):
            run = scored_run(takeoff, flight)
            measured = {name: float(run.metrics.get(name, np.nan)) for name in MEASURES}
            scores.append({**measured, "lost": run.failed})
        kept.with_suffix(".part").write_text(json.dumps(scores), encoding="utf-8")
        kept.with_suffix(".part").replace(kept)
    return scores[:draws]


def row(controller: str, posture: str, margin: float | None, scores: list[dict[str, Any]]) -> str:
    """A line of the table."""
    kept = [score for score in scores if not score["lost"]]
    spread, line, contact = (np.array([score[name] for score in kept]) for name in MEASURES)
    return (
        f"| `{controller}` | {posture} | {'cannot hold it' if margin is None else f'{margin:.2f}'} "
        f"| {len(scores) - len(kept)} of {len(scores)} | {100 * np.median(contact):.0f} % "
        f"| {np.median(spread):.2f}, {np.quantile(spread, 0.9):.2f} "
        f"| {1e3 * np.median(line):.1f}, {1e3 * np.quantile(line, 0.9):.1f} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument("--controllers", nargs="+", default=("hybrid", "following"))
    given = parser.parse_args()
    experiment, robot, lines = (
        skylimb.load_experiment("paper"),
        skylimb.load_robot("hydrus_xi_quad"),
        list[str](HEAD),
    )
    for controller in given.controllers:
        folder = KEPT / controller
        plan = plan_posture(experiment, robot, skylimb.load_controller(controller, robot), by="margin")
        if not (folder / "planned").exists():
            folder.mkdir(parents=True, exist_ok=True)
            write_planned(plan, folder / "planned")
        planned = str(folder / "planned" / EXPERIMENT)
        own = plan.nominal.margin if plan.nominal else None
        for posture, margin, flies in (
            ("the paper's", own, "paper"),
            ("planned", plan.planned.margin, planned),
        ):
            scores = flown(
                flies, controller, given.draws, folder / ("own.json" if flies == "paper" else "planned.json")
            )
            lines.append(row(controller, posture, margin, scores))
            print(lines[-1], flush=True)
    page = PAGE.read_text(encoding="utf-8")
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    PAGE.write_text(f"{before}{BEGIN}\n\n" + "\n".join(lines) + f"\n\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
