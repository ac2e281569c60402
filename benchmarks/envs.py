"""Measure environments to learn in: physics steps a second of whole episodes against a raw replay.

    python benchmarks/envs.py
    python benchmarks/envs.py --task pushing --environments 1 8 64
    python benchmarks/envs.py --rivals

The replay makes the same physics steps with a flight's own controls from a table, by the engine's own loop
in C, and nothing else (`native.py`). Both are on one thread, in its own processor time, in the same run, the
least of several in turns. Episodes have their take-offs in them, of draws that were met before. Exits with 1
when many environments fall short. `--rivals` asks the same of crazyflow and RotorPy, each by itself
(`compare.py`): its environments to learn in against its batch of vehicles alone, on one core.
"""

from __future__ import annotations

import argparse
import sys
import time

import compare
import native
import numpy as np
from rich.console import Console
from rich.table import Table

from skylimb.envs import FlightVectorEnv
from skylimb.flight.takeoff import prepare

RATIO_WANTED = 0.6
DRAWS = 4


def episode(env: FlightVectorEnv, rng: np.random.Generator) -> tuple[float, int]:
    """Processor seconds and physics steps of an episode in every environment, its take-off among them."""
    ended = np.zeros(env.num_envs, bool)
    actions = rng.uniform(-0.2, 0.2, (400, env.num_envs, len(env.fleet.actions.names))).astype(np.float32)
    start, k = time.thread_time(), 0
    env.reset()
    while not ended.any():
        _, _, lost, over, _ = env.step(actions[k % len(actions)])
        ended, k = lost | over, k + 1
    took = time.thread_time() - start
    return took, sum(int(flight.record.done) for flight in env.fleet.flights.flights)


def rivals(count: int, repeats: int) -> Table:
    """What others' environments keep of the physics that stands behind them."""
    table = Table("", "physics steps/s alone", "of its environments", "share")
    for rival in compare.RIVALS:
        name, script = rival.name, f"learn_{rival.stem}.py"
        if not (compare.HERE / script).exists():
            continue
        python, problem = compare.environment(rival.stem)
        found = {} if problem else compare.answer(str(python), script, environments=count, repeats=repeats)
        if problem or "problem" in found:
            table.add_row(name, problem or found["problem"])
            continue
        raw, own = found["raw"], found["own"]
        table.add_row(f"{name}, {count} environments", f"{raw:,.0f}", f"{own:,.0f}", f"{own / raw:.2f}")
    return table


def main() -> int:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--task", default="sliding")
    parser.add_argument("--environments", type=int, nargs="+", default=[1, 64])
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--rivals", action="store_true", help="crazyflow's and RotorPy's as well")
    asked = parser.parse_args()
    vary = {"surface.friction": {"uniform": [0.1, 0.4]}}
    table = Table("", "physics steps/s", "control ticks/s", "of the raw replay")
    short = False
    for count in asked.environments:
        env = FlightVectorEnv(count, task=asked.task, vary=vary, draws=DRAWS)
        env.reset(seed=0)
        for draw in range(DRAWS):
            env.fleet.restart([0], [draw])
        takeoff, rng = env.fleet.start(0)[1], np.random.default_rng(0)
        plain = prepare(takeoff.experiment, takeoff.robot, takeoff.controller)
        replayed, raw, own = len(native.controls_of(plain)[0]), [0.0], [0.0]
        for _ in range(asked.repeats):
            raw.append(replayed / native.closed_over_replay(plain, 1)[1])
            took, steps = episode(env, rng)
            own.append(steps / took)
        ratio = max(own) / max(raw)
        for what, most, part in (("raw replay", max(raw), 1.0), (f"{count} environments", max(own), ratio)):
            table.add_row(what, f"{most:,.0f}", f"{most / takeoff.plant.substeps:,.0f}", f"{part:.2f}")
        short |= count >= 64 and ratio < RATIO_WANTED
    Console().print(table)
    if asked.rivals:
        Console().print(rivals(max(asked.environments), asked.repeats))
    return int(short)


if __name__ == "__main__":
    sys.exit(main())
