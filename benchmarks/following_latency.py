"""How late the motion capture may be for the preset `following`, where its latency is known and where not.

    python benchmarks/following_latency.py    (ten minutes on one core)

The paper's experiment with three seeds at every latency. The table of docs/reports/following_results.md is
written anew.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from kept import fill  # beside this file

from skylimb.analysis.recording.run import Run
from skylimb.control.controller import load_controller
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.experiments.experiment import load_experiment
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import prepare
from skylimb.robots.loader import load_robot

PAGE = Path(__file__).parents[1] / "docs" / "reports" / "following_results.md"
LATENCIES = tuple(range(5, 75, 5))
SEEDS = (0, 1, 2)
BELIEVED = 20


def flown(latency: int, believed: int) -> list[Run]:
    """The flights of all seeds with this latency, ms, and the one that the controller believes."""
    experiment = load_experiment("paper")
    robot = load_robot(experiment.robot)
    controller = load_controller("following", robot, {"estimation.delay.latency": 1e-3 * believed})
    given: dict[str, Any] = {"sensors.latency": 1e-3 * latency}
    ready = [prepare(load_experiment("paper", {**given, "seed": seed}), robot, controller) for seed in SEEDS]
    return [scored_run(takeoff, flight) for takeoff, flight in zip(ready, fly_native(ready), strict=True)]


def cells(runs: list[Run]) -> list[str]:
    """Of flights: how many were done, lost, and the worst of the force's deviation and of the touch."""
    kept = [run.metrics for run in runs if run.status == "OK"]
    numbers = [str(sum(run.done is True for run in runs)), str(len(runs) - len(kept))]
    if not kept:
        return [*numbers, "", ""]
    deviation = max(float(one["contact_force_normal_std"]) for one in kept)
    touch = min(float(one["contact_fraction"]) for one in kept)
    return [*numbers, f"{deviation:.2f}", f"{100.0 * touch:.0f}"]


def main() -> None:
    """Fly everything, and write the table."""
    head = ["latency ms"]
    for what in (f"{BELIEVED} ms believed", "known"):
        head += [f"{what}: done of {len(SEEDS)}", "lost", "force std N", "touch %"]
    lines = [head, ["---"] * len(head)]
    for latency in LATENCIES:
        lines.append([str(latency), *cells(flown(latency, BELIEVED)), *cells(flown(latency, latency))])
        print(" | ".join(lines[-1]), flush=True)
    fill(PAGE, "latency", "\n".join("| " + " | ".join(line) + " |" for line in lines))


if __name__ == "__main__":
    main()
