"""What a controller in plain Python costs that takes 20 us a tick: its flight against a raw replay.

    python benchmarks/own_python.py          (or --repeats 20)

The controller gives the commands that a flight of the hybrid left, each after 20 us of doing nothing. So both
fly the paper's flight with its contact, and the physics is the same in both.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from typing import Any

import loop
import numpy as np
import xarray as xr

import skylimb
from skylimb.flight.flying import begin_loop
from skylimb.flight.takeoff import take_off
from skylimb.simulation.engine_timer import without_timer

EXPERIMENT, CONTROLLER = "paper", "hybrid"
STEP_TIME = 20e-6
"""How long a step of the controller takes, s."""
WANTED = 2.0
"""Times a raw replay that its flight may take."""


class Recorded:
    """Gives recorded commands, one a tick, each after `STEP_TIME`.

    Args:
        commands: of every tick.
    """

    name = "recorded"

    def __init__(self, commands: Sequence[skylimb.Command]) -> None:
        self._commands = commands

    def gains(self) -> None:
        """None."""
        return None

    def initial_state(self) -> int:
        """The number of the next tick."""
        return 0

    def step(
        self, gains: None, state: int, measurement: Any, reference: Any, dt: float
    ) -> tuple[int, skylimb.Command, dict[str, Any]]:
        """The command of this tick."""
        until = time.perf_counter() + STEP_TIME
        while time.perf_counter() < until:
            pass
        return state + 1, self._commands[state], {}


def commands_of(log: xr.Dataset) -> list[skylimb.Command]:
    """The commands of a whole flight."""
    names = ("thrusts_command", "joint_angles_command", "vectoring_angles_command")
    return [skylimb.Command(*row) for row in zip(*(log[name].values for name in names), strict=True)]


def measure(repeats: int) -> tuple[float, float]:
    """Seconds of the controller's flight and of a raw replay, the least of several in turns."""
    bench, _ = loop.prepare(EXPERIMENT, CONTROLLER)
    controls, end = loop.record_controls(bench)
    recorded = skylimb.run(EXPERIMENT, controller=CONTROLLER).log
    (takeoff,) = take_off(EXPERIMENT, (Recorded(commands_of(recorded)),))
    last = recorded.configuration.values[-1]

    def flight() -> float:
        with without_timer():
            ready = begin_loop(takeoff)
            start = time.perf_counter()
            result = ready.fly()
            elapsed = time.perf_counter() - start
        if result.cause or not np.array_equal(result.signal("configuration")[-1], last):
            raise SystemExit("the controller's flight is not the one that was recorded")
        return elapsed

    def replay() -> float:
        data = bench.takeoff.data()
        start = time.perf_counter()
        bench.replay(data, controls)
        elapsed = time.perf_counter() - start
        if not np.array_equal(np.concatenate([data.qpos, data.qvel]), end):
            raise SystemExit("the replay did not end where the flight did")
        return elapsed

    flown, replayed = loop.fastest(repeats, flight, replay)
    return flown, replayed


def main() -> int:
    """Print what was measured; 1 when it falls short."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--repeats", type=int, default=7)
    flight, replay = measure(parser.parse_args().repeats)
    print(f"flight of a Python controller of {1e6 * STEP_TIME:.0f} us a tick  {flight:.3f} s")
    print(f"raw replay of the same controls                {replay:.3f} s")
    print(f"ratio {flight / replay:.2f}  (wanted: at most {WANTED:g})")
    return 0 if flight <= WANTED * replay else 1


if __name__ == "__main__":
    raise SystemExit(main())
