"""Measure environments to learn in: physics steps a second of whole episodes against a raw replay.

    python benchmarks/envs.py
    python benchmarks/envs.py --task pushing --environments 1 8 64

The replay makes the same physics steps with a flight's own controls from a table, by the engine's own loop
in C, and nothing else (`native.py`). Both are on one thread, in its own processor time, in the same run, the
least of several in turns. Episodes have their take-offs in them, of draws that were met before. Exits with 1
when many environments fall short.
"""

from __future__ import annotations

import argparse
import sys
import time

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


def main() -> int:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--task", default="sliding")
    parser.add_argument("--environments", type=int, nargs="+", default=[1, 64])
    parser.add_argument("--repeats", type=int, default=3)
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
    return int(short)


if __name__ == "__main__":
    sys.exit(main())
