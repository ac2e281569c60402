"""The planned posture against the robot's own, the same experiment, draws of friction, slope and noise.

    python benchmarks/planned_posture.py [--draws 100] [--controllers hybrid following] [--robots dragon ...]

Per draw the friction is between 0.2 and 0.6, the slope between 10 and 25 degrees as the paper's, and the
seed of the noise another (`SEED` and the draw's number). Two tables go into docs/reports/feasibility.md: of
hydrus_xi_quad by its margin alone, for some controllers, and of every robot what `skylimb plan` proposes for
`following`, which has to fly as well. Plans and scores are kept in out/planned_posture, so that an
interrupted run goes on; remove it after a change of the planner.
"""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from kept import fill, filled  # beside this file
from transformations import PAGE

import skylimb
from skylimb.base.errors import SkylimbError
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.experiments.experiment import Experiment, load_experiment
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import take_off
from skylimb.studies.planning.task_plan import EXPERIMENT, By, plan_posture, write_planned

SEED = 7
TOGETHER = 10
QUAD = "hydrus_xi_quad"
ROBOTS = (
    QUAD,
    "hydrus_xi_quad_mast",
    "hydrus_quad",
    "hydrus_xi_hex",
    "dragon",
    "tilted_hexarotor",
    "tiltable_hexarotor",
)
POSTURES = ("own", "planned")
KEPT = PAGE.parents[2] / "out" / "planned_posture"
MEASURES = ("contact_force_normal_std", "pen_line_rms", "contact_fraction")
HEAD = (
    "| robot | controller | posture | planned for: worst margin, N m | lost | contact kept "
    "| force spread, N: median, 90 % "
    "| pen line, mm: median, 90 % |",
    "|---|---|---|---|---|---|---|---|",
)


def drawn(draw: int) -> dict[str, Any]:
    """What is different in a draw."""
    rng = np.random.default_rng([SEED, draw])
    slope = np.radians(rng.uniform(10.0, 25.0))
    return {"surface.friction": float(rng.uniform(0.2, 0.6)), "surface.slope": float(slope)}


def flown(experiment: Experiment, controller: str, draws: int, kept: Path) -> list[dict[str, Any]]:
    """The scores of every draw, kept in a file after each few flights."""
    scores = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else []
    for first in range(len(scores), draws, TOGETHER):
        seeds = range(first, min(first + TOGETHER, draws))
        some = [take_off(experiment, (controller,), seed, drawn(seed))[0] for seed in seeds]
        for takeoff, flight in zip(some, fly_native(some), strict=True):
            run = scored_run(takeoff, flight)
            measured = {name: run.metrics.get(name) for name in MEASURES}  # None of a lost one
            scores.append({**measured, "lost": run.failed})
        kept.with_suffix(".part").write_text(json.dumps(scores), encoding="utf-8")
        kept.with_suffix(".part").replace(kept)
    return scores[:draws]


def row(posture: str, margin: float | None, scores: list[dict[str, Any]]) -> str:
    """A line of a table."""
    kept = [score for score in scores if not score["lost"]]
    if not kept:
        return f"| {posture} | {_said(margin)} | {len(scores)} of {len(scores)} | - | - | - |"
    spread, line, contact = (np.array([score[name] for score in kept]) for name in MEASURES)
    return (
        f"| {posture} | {_said(margin)} "
        f"| {len(scores) - len(kept)} of {len(scores)} | {100 * np.median(contact):.0f} % "
        f"| {np.median(spread):.2f}, {np.quantile(spread, 0.9):.2f} "
        f"| {1e3 * np.median(line):.1f}, {1e3 * np.quantile(line, 0.9):.1f} |"
    )


def _said(margin: float | None) -> str:
    """A margin, N m, or that there is none."""
    return "cannot hold it" if margin is None else f"{margin:.2f}"


def compared(name: str, controller: str, by: By, draws: int) -> Iterator[str]:
    """Lines of a robot and a controller: its own posture and the planned one; below the table, why not."""
    folder, own = KEPT / name / f"{controller}-{by}", f"| `{name}` | `{controller}`"
    experiment = skylimb.load_experiment("paper", {"robot": name})
    plan = proposed(experiment, name, controller, by, folder)
    if isinstance(plan, str):
        yield f"- {plan}."
        return
    for posture, margin in zip(POSTURES, plan, strict=True):
        flies = (
            experiment if posture == POSTURES[0] else load_experiment(str(folder / "planned" / EXPERIMENT))
        )
        scores = flown(flies, controller, draws, folder / f"{posture}.json")
        yield f"{own} {row(posture, margin, scores)}"


def proposed(
    experiment: Experiment, name: str, controller: str, by: By, folder: Path
) -> tuple[float | None, float] | str:
    """Margins of the robot's own posture and the planned one, N m; of a robot that keeps its own, why."""
    kept = folder / "plan.json"
    if not kept.exists():
        folder.mkdir(parents=True, exist_ok=True)
        robot = skylimb.load_robot(name)
        try:
            plan = plan_posture(experiment, robot, skylimb.load_controller(controller, robot), by=by)
            write_planned(plan, folder / "planned")
            found: Any = [plan.nominal.margin if plan.nominal else None, plan.planned.margin]
        except SkylimbError as error:
            found = str(error).partition("; by =")[0]
        kept.write_text(json.dumps(found), encoding="utf-8")
    found = json.loads(kept.read_text(encoding="utf-8"))
    return found if isinstance(found, str) else (found[0], found[1])


def robot_of(line: str) -> str:
    """The robot that a line of a table or of the reasons below it is about; empty for any other line."""
    found = re.match(r"\| `(\w+)`|- '(\w+)'", line)
    return (found[1] or found[2]) if found else ""


def main() -> None:
    """Fly what is missing, and write both tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument("--controllers", nargs="*", default=("hybrid", "following"), help="by margin")
    parser.add_argument(
        "--robots", nargs="*", default=ROBOTS, choices=ROBOTS, help="with `following`, by flight"
    )
    given = parser.parse_args()
    cases: dict[str, list[tuple[str, str, By]]] = {
        "planned": [(QUAD, controller, "margin") for controller in given.controllers],
        "planned robots": [(robot, "following", "flight") for robot in given.robots],
    }
    for table, some in cases.items():
        if some:
            # Of robots that nobody asked for now, the page says what it said.
            asked = {"", *(robot for robot, _, _ in some)}
            rows = [line for line in filled(PAGE, table) if robot_of(line) not in asked]
            for case in some:
                for line in compared(*case, given.draws):
                    rows.append(line)
                    print(line, flush=True)
            rows.sort(key=lambda line: ROBOTS.index(robot_of(line)))
            flown_ones = [line for line in rows if line.startswith("|")]
            reasons = [line for line in rows if not line.startswith("|")]
            fill(PAGE, table, "\n".join([*HEAD, *flown_ones, "", *reasons]).rstrip())


if __name__ == "__main__":
    main()
