"""Measure the native driver: closed loop against a raw replay, many flights on threads, memory.

    python benchmarks/native.py
    python benchmarks/native.py --controller pid --flights 64

The replay makes the same physics steps with the flight's own controls from a table, by the engine's own loop
in C, and nothing else. Times are the least of several runs taken in turns. Exits with 1 when a figure falls
short.
"""

from __future__ import annotations

import argparse
import dataclasses
import resource
import sys
import time
from collections.abc import Callable

import mujoco
import numpy as np
from mujoco.batch import Batch
from rich.console import Console
from rich.table import Table

from skylimb.analysis.scores.user_scores import scored
from skylimb.control.loop.loop import Loop
from skylimb.flight.drivers.compiled import CompiledDriver
from skylimb.flight.drivers.native import compile_native, fly_native, unavailable
from skylimb.flight.drivers.world import world
from skylimb.flight.simulated_run import simulated_run
from skylimb.flight.takeoff import Takeoff, take_off
from skylimb.simulation.engine_timer import without_timer

RATIO_WANTED = 0.95
MINUTES_WANTED, FLIGHTS_WANTED = 2.5, 1000
SCALING_WANTED = 1.85
MEMORY_WANTED = 400.0  # MB
_STATE = mujoco.mjtState.mjSTATE_INTEGRATION
_GIVEN = int(mujoco.mjtState.mjSTATE_CTRL | mujoco.mjtState.mjSTATE_QFRC_APPLIED)


def prepare(experiment: str, controller: str) -> Takeoff:
    """Everything before a flight."""
    (takeoff,) = take_off(experiment, (controller,))
    compile_native(takeoff.tick.function)
    return takeoff


def with_seed(takeoff: Takeoff, seed: int) -> Takeoff:
    """The same flight with other noise."""
    return takeoff.changed(dataclasses.replace(takeoff.experiment, seed=seed))


def controls_of(takeoff: Takeoff) -> tuple[np.ndarray, np.ndarray]:
    """Controls and joint forces of every step, as the compiled driver flies, and the state at the end."""
    plant, data, acts, events, _ = world(takeoff)
    controls = np.zeros((len(takeoff.rows), plant.model.nu + plant.model.nv))

    def watch(k: int) -> None:
        controls[k] = np.concatenate([data.ctrl, data.qfrc_applied])

    driver = CompiledDriver(takeoff.tick, plant, data, takeoff.rows, [*acts, watch], events.gains)
    flight = Loop(driver, takeoff.mission, takeoff.experiment.terminations, len(takeoff.rows)).fly()
    if flight.cause:
        raise SystemExit(f"the flight failed: {flight.cause}")
    return np.repeat(controls[: flight.ticks], plant.substeps, axis=0), np.concatenate([data.qpos, data.qvel])


def seconds(work: Callable[[], object], clock: Callable[[], float] = time.perf_counter) -> float:
    start = clock()
    work()
    return clock() - start


def fastest(repeats: int, *works: Callable[[], float]) -> list[float]:
    """The least time of each work, taken in turns."""
    return [min(times) for times in zip(*([work() for work in works] for _ in range(repeats)), strict=True)]


def closed_over_replay(takeoff: Takeoff, repeats: int) -> list[float]:
    """Processor seconds of the closed loop, of the raw replay, and of that without the engine's timer.

    Each is on the caller's thread alone.
    """
    controls, end = controls_of(takeoff)

    def replay() -> float:
        batch = Batch(takeoff.plant.model, 1, 1)
        mujoco.mj_getState(takeoff.plant.model, takeoff.data(), batch.state[0], _STATE)
        took = seconds(
            lambda: batch.rollout(len(controls), controls[None], _GIVEN, record=()), time.thread_time
        )
        if not np.array_equal(np.concatenate([batch.qpos[0], batch.qvel[0]]), end):
            raise SystemExit("the replay did not end where the flight did: the comparison means nothing")
        return took

    def closed() -> float:
        return seconds(lambda: fly_native([takeoff]), time.thread_time)

    def untimed() -> float:
        with without_timer():
            return replay()

    return fastest(repeats, closed, replay, untimed)


def memory() -> float:
    """Most memory that the process has had, MB."""
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most / (2**20 if sys.platform == "darwin" else 2**10)


@dataclasses.dataclass(frozen=True)
class Figures:
    """What was measured.

    Attributes:
        flown: length of a flight, s.
        ticks: of a flight.
        substeps: physics steps of a tick.
        closed: processor seconds of a flight.
        raw: processor seconds of the raw replay of its controls, the engine as its bindings set it up.
        bare: the same without the engine's timer, which the driver takes away as well.
        threads: number of threads -> wall seconds a flight, many at once.
        before: seconds for scene, mission and noise of a flight.
        after: seconds for log and metrics of a flight.
        memory: most that the process has had, MB.
    """

    flown: float
    ticks: int
    substeps: int
    closed: float
    raw: float
    bare: float
    threads: dict[int, float]
    before: float
    after: float
    memory: float

    @property
    def ratio(self) -> float:
        """Closed loop over raw replay, in speed."""
        return self.raw / self.closed

    @property
    def strict(self) -> float:
        """Closed loop over the replay without the engine's timer, in speed."""
        return self.bare / self.closed


def measure(name: str, controller: str, flights: int, repeats: int) -> Figures:
    """Fly one, replay it, fly many, and time what comes before and after."""
    takeoff = prepare(name, controller)
    closed, raw, bare = closed_over_replay(takeoff, repeats)
    many = [with_seed(takeoff, seed) for seed in range(flights)]
    for one in many:
        _ = one.rows  # drawn before the clock starts
    one, two = fastest(
        repeats,
        lambda: seconds(lambda: fly_native(many, 1)),
        lambda: seconds(lambda: fly_native(many, 2)),
    )
    [flight] = fly_native([takeoff])

    def scene() -> None:
        (fresh,) = take_off(name, (takeoff.controller,))
        fresh.data()
        _ = fresh.tick, fresh.rows

    before, after = fastest(
        repeats,
        lambda: seconds(scene),
        lambda: seconds(lambda: scored(simulated_run(takeoff, flight))),
    )
    return Figures(
        flown=flight.ticks * takeoff.period,
        ticks=flight.ticks,
        substeps=takeoff.plant.substeps,
        closed=closed,
        raw=raw,
        bare=bare,
        threads={1: one / flights, 2: two / flights},
        before=before,
        after=after,
        memory=memory(),
    )


def main() -> int:
    """Print what was measured; 1 when a figure falls short."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--experiment", default="paper")
    parser.add_argument("--controller", default="hybrid")
    parser.add_argument("--flights", type=int, default=12, help="flown at once")
    parser.add_argument("--repeats", type=int, default=7)
    options = parser.parse_args()
    if unavailable():
        raise SystemExit(f"no native driver here: {unavailable()}")
    return report(options, measure(options.experiment, options.controller, options.flights, options.repeats))


def report(options: argparse.Namespace, found: Figures) -> int:
    """Print what was measured; 1 when a figure falls short."""
    one, two = found.threads[1], found.threads[2]
    minutes = FLIGHTS_WANTED * two / 60.0
    figures = (
        ("closed loop / raw replay", found.ratio, f"at least {RATIO_WANTED:g}", found.ratio >= RATIO_WANTED),
        (
            f"{FLIGHTS_WANTED} flights on two threads, min",
            minutes,
            f"at most {MINUTES_WANTED:g}",
            minutes <= MINUTES_WANTED,
        ),
        ("two threads / one", one / two, f"at least {SCALING_WANTED:g}", one / two >= SCALING_WANTED),
        ("memory, MB", found.memory, f"at most {MEMORY_WANTED:g}", found.memory <= MEMORY_WANTED),
    )
    console = Console(highlight=False)
    console.print(
        f"{options.experiment}, {options.controller}: {found.flown:.1f} s of flight in {found.ticks} ticks "
        f"of {found.substeps} steps, {options.flights} at once, fastest of {options.repeats}; closed loop "
        f"over a replay without the engine's timer {found.strict:.3f}"
    )
    table = Table("", "measured", "wanted", "", box=None, pad_edge=False)
    for name, value, wanted, good in figures:
        table.add_row(name, f"{value:.3g}", wanted, "" if good else "short")
    console.print(table)
    console.print(
        f"a tick of the closed loop {1e6 * found.closed / found.ticks:.2f} us, of the replay "
        f"{1e6 * found.raw / found.ticks:.2f} us; a flight {1e3 * one:.0f} ms ({found.flown / one:.0f} x "
        f"real time), before it {1e3 * found.before:.0f} ms for scene, mission and noise, after it "
        f"{1e3 * found.after:.0f} ms for log and metrics"
    )
    return 0 if all(good for *_, good in figures) else 1


if __name__ == "__main__":
    raise SystemExit(main())
