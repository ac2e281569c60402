"""What plain Python of 20 us a tick costs, as a controller and as a law in a slot: against a raw replay.

    python benchmarks/own_python.py          (or --repeats 20)

The controller gives the commands that a flight of the hybrid left, each after 20 us of doing nothing. The law
is the hybrid's translation law in NumPy, which then waits until 20 us are over; the rest of the cascade is
compiled. So all fly the paper's flight with its contact, and the physics is the same.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import loop
import numpy as np
import xarray as xr

import skylimb
from skylimb.base.config import write_toml
from skylimb.control.laws.preset import preset_mapping
from skylimb.flight.flying import begin_loop
from skylimb.flight.takeoff import Takeoff, take_off
from skylimb.simulation.engine_timer import without_timer

EXPERIMENT, CONTROLLER = "paper", "hybrid"
STEP_TIME = 20e-6
"""How long a step of the controller takes, s."""
WANTED = 2.5
"""Times a raw replay that a flight may take."""

LAW = f"""
import time
from skylimb.control.translation.laws import impedance
from skylimb.control.translation.laws.impedance import Gains, initial_state

def step(gains, state, inputs):
    until = time.perf_counter() + {STEP_TIME}
    float(inputs.reference.heading)
    made = impedance.step(gains, state, inputs)
    while time.perf_counter() < until:
        pass
    return made
"""


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


def preset_with(folder: Path) -> str:
    """The hybrid with `LAW` in its translation slot, as a file in a folder."""
    (folder / "waiting.py").write_text(LAW, encoding="utf-8")
    tables, _ = preset_mapping(CONTROLLER)
    tables["translation"]["law"] = "waiting.py"
    (folder / "waiting.toml").write_text(write_toml(tables), encoding="utf-8")
    return str(folder / "waiting.toml")


def measure(repeats: int) -> tuple[float, float, float]:
    """Seconds of the controller's flight, of the law's and of a raw replay, the least of several in turns."""
    bench, _ = loop.prepare(EXPERIMENT, CONTROLLER)
    controls, end = loop.record_controls(bench)
    recorded = skylimb.run(EXPERIMENT, controller=CONTROLLER).log
    with tempfile.TemporaryDirectory() as folder:
        own = Recorded(commands_of(recorded)), preset_with(Path(folder))
        takeoffs = take_off(EXPERIMENT, own)
    last = recorded.configuration.values[-1]

    def flight(takeoff: Takeoff) -> float:
        with without_timer():
            ready = begin_loop(takeoff)
            start = time.perf_counter()
            result = ready.fly()
            elapsed = time.perf_counter() - start
        if result.cause or not np.allclose(result.signal("configuration")[-1], last, atol=1e-6):
            raise SystemExit("the flight in Python is not the one that was recorded")
        return elapsed

    def replay() -> float:
        data = bench.takeoff.data()
        start = time.perf_counter()
        bench.replay(data, controls)
        elapsed = time.perf_counter() - start
        if not np.array_equal(np.concatenate([data.qpos, data.qvel]), end):
            raise SystemExit("the replay did not end where the flight did")
        return elapsed

    flight(takeoffs[1])  # now its two compiled parts have been met, and are built
    flights = (partial(flight, takeoff) for takeoff in takeoffs)
    controller, law, replayed = loop.fastest(repeats, *flights, replay)
    return controller, law, replayed


def main() -> int:
    """Print what was measured; 1 when it falls short."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--repeats", type=int, default=7)
    controller, law, replay = measure(parser.parse_args().repeats)
    print(f"raw replay of the same controls                {replay:.3f} s")
    for what, took in (("controller", controller), ("law in a slot", law)):
        text = f"flight of a Python {what} of {1e6 * STEP_TIME:.0f} us a tick"
        print(f"{text:<46} {took:.3f} s, ratio {took / replay:.2f}  (wanted: at most {WANTED:g})")
    return 0 if max(controller, law) <= WANTED * replay else 1


if __name__ == "__main__":
    raise SystemExit(main())
