"""What servo friction and the contact's solver cost a physics step, and what they change in the scores.

    python benchmarks/servo_friction.py --seeds 20

The plant has each joint's dry friction as a motor that saturates, and the dual solver for its one touch.
The other rows are what could stand in their place. Every row flies the same flights. Steps are timed in
replays of each row's own controls, in turns. Of every stretch of a flight the fastest repeat counts, so that
what slows a repeat down from outside has no part in it. A score's change is that of its median over seeds.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import loop
import mujoco
import numpy as np
from rich.console import Console
from rich.table import Table

import skylimb
from skylimb.robots.description import RobotDescription
from skylimb.simulation import plant
from skylimb.simulation.engine_timer import without_timer
from skylimb.simulation.scene import scene_spec
from skylimb.simulation.surface_bodies import SurfaceParts

_NEWTON, _PGS = int(mujoco.mjtSolver.mjSOL_NEWTON), int(mujoco.mjtSolver.mjSOL_PGS)
_STRETCH = 125  # ticks
_FLOWN = ("pid", "impedance", "admittance", "hybrid", "following")


@dataclass(frozen=True)
class Row:
    """What a plant has in the place of friction and solver.

    Attributes:
        friction: "constraint" (the engine's own), "motor" or "none".
        solver: of the engine.
    """

    friction: str
    solver: int

    def scene(self, description: RobotDescription, *given: Any) -> tuple[mujoco.MjSpec, SurfaceParts]:
        """`scene_spec` with these."""
        spec, parts = scene_spec(description, *given)
        spec.option.solver = self.solver
        for joint in description.joints:
            if joint.kind == "fixed" or self.friction == "motor":
                continue
            spec.delete(spec.actuator(f"{joint.name}_friction"))
            if self.friction == "constraint":
                spec.joint(joint.name).frictionloss = joint.friction
        return spec, parts


ROWS = {
    "the engine's constraint, Newton's solver": Row("constraint", _NEWTON),
    "the engine's constraint, dual solver": Row("constraint", _PGS),
    "a motor that saturates, Newton's solver": Row("motor", _NEWTON),
    "a motor that saturates, dual solver (flown)": Row("motor", _PGS),
    "no friction, dual solver": Row("none", _PGS),
}


@contextmanager
def scenes(row: Row) -> Iterator[None]:
    """Build every plant with a row's scene."""
    plant.scene_spec = row.scene
    try:
        yield
    finally:
        plant.scene_spec = scene_spec


def time_steps(controller: str, repeats: int) -> dict[str, float]:
    """Seconds of a physics step of each row."""
    replays: dict[str, Callable[[], np.ndarray]] = {}
    for name, row in ROWS.items():
        with scenes(row):
            bench, _ = loop.prepare("paper", controller)
        controls, _ = loop.record_controls(bench)

        def replay(bench: loop.Bench = bench, controls: np.ndarray = controls) -> np.ndarray:
            data, took = bench.takeoff.data(), []
            for first in range(0, len(controls), _STRETCH):
                start = time.thread_time()
                bench.replay(data, controls[first : first + _STRETCH])
                took.append(time.thread_time() - start)
            return np.array(took) / (len(controls) * bench.takeoff.plant.substeps)

        replays[name] = replay
    with without_timer():
        rounds = [[replay() for replay in replays.values()] for _ in range(repeats)]
    return {
        name: float(np.min(taken, axis=0).sum())
        for name, taken in zip(replays, zip(*rounds, strict=True), strict=True)
    }


def median_scores(row: Row, experiments: Sequence[str], seeds: int) -> dict[tuple[str, ...], float]:
    """Medians of every score over the flights that came home, and the number of flights lost."""
    medians: dict[tuple[str, ...], float] = {}
    with scenes(row):
        for experiment in experiments:
            for controller in _FLOWN:
                runs = [skylimb.run(experiment, controller=controller, seed=seed) for seed in range(seeds)]
                home = [run.metrics for run in runs if run.status == "OK"]
                medians[experiment, controller, "flights lost"] = float(seeds - len(home))
                for name in home[0] if home else ():
                    values = [metrics[name] for metrics in home]
                    if all(isinstance(value, float | int) for value in values):
                        medians[experiment, controller, name] = float(np.nanmedian(values))
    return medians


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--controller", default="hybrid", help="whose flight is timed")
    parser.add_argument("--repeats", type=int, default=15)
    parser.add_argument("--seeds", type=int, default=0, help="flights a controller; 0 leaves the scores out")
    parser.add_argument("--experiments", nargs="+", default=["paper", "sine_gentle"])
    options = parser.parse_args()
    steps = time_steps(options.controller, options.repeats)
    first = next(iter(steps.values()))
    scores = {
        name: median_scores(row, options.experiments, options.seeds)
        for name, row in ROWS.items()
        if options.seeds
    }
    table = Table("", "us a step", "to the first", "largest change of a score", "flights lost", box=None)
    for name, seconds in steps.items():
        cells = ["", ""]
        if options.seeds:
            cells = [*largest_change(scores[next(iter(ROWS))], scores[name])]
        table.add_row(name, f"{1e6 * seconds:.2f}", f"{seconds / first:.2f}", *cells)
    Console(highlight=False, width=160).print(table)
    return 0


def largest_change(
    before: dict[tuple[str, ...], float], after: dict[tuple[str, ...], float]
) -> tuple[str, str]:
    """The score that changes most and by how much, and the flights lost."""
    changes = {
        key: abs(after[key] / value - 1.0)
        for key, value in before.items()
        # A median of a small count jumps by halves.
        if key in after and key[2] not in ("flights lost", "contact_losses") and value
    }
    worst = max(changes, key=lambda key: changes[key])
    lost = sum(value for key, value in after.items() if key[2] == "flights lost")
    return f"{100.0 * changes[worst]:.1f} % ({', '.join(worst)})", f"{lost:.0f}"


if __name__ == "__main__":
    raise SystemExit(main())
