"""How fast the closed loop is, against a raw replay of the very same controls, and where its time goes.

    make bench          (or: python benchmarks/loop.py --controller pid --repeats 20)

The closed loop has everything on: sensors with noise and latency, observer, laws, allocation, actuators, the
full record and the watch for a lost flight. The raw replay does nothing but hand recorded controls, and the
torques of rotors on their bodies, to MuJoCo. Both start from the same state and must end in the same bits.
They take turns, and the fastest of each counts:
what slows a flight down from outside is no property of the loop.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import mujoco
import numpy as np
from rich.console import Console
from rich.table import Table

from skylimb.control.loop.flight import Flight
from skylimb.control.loop.loop import CHECK_INTERVAL, Loop
from skylimb.control.loop.terminations import find_loss
from skylimb.flight.drivers.compiled import CompiledDriver
from skylimb.flight.drivers.machine_code import worth_building
from skylimb.flight.drivers.world import World, world
from skylimb.flight.flying import fastest_tick
from skylimb.flight.takeoff import Takeoff, take_off
from skylimb.simulation.engine_timer import without_timer
from skylimb.simulation.tick import CompiledTick

T = TypeVar("T")
RATIO_WANTED = 0.88
TICK_WANTED = 6e-6


@dataclass
class Bench:
    """One flight, ready to be repeated, and the tick that the Python driver would take here."""

    takeoff: Takeoff
    tick: CompiledTick

    @property
    def ticks(self) -> int:
        return len(self.takeoff.mission.times)

    def closed_loop(self, here: World, watch: Callable[[int], None] | None = None) -> Flight:
        takeoff, acts = self.takeoff, [*here.hooks, *([watch] if watch else [])]
        driver = CompiledDriver(self.tick, here.plant, here.data, takeoff.rows, acts, here.events.gains)
        with without_timer():
            limits = takeoff.experiment.terminations
            return Loop(driver, takeoff.mission, limits, len(takeoff.times)).fly()

    def replay(self, data: mujoco.MjData, controls: np.ndarray) -> None:
        plant = self.takeoff.plant
        step, model, substeps, nu = mujoco.mj_step, plant.model, plant.substeps, plant.model.nu
        ctrl, force = data.ctrl, data.qfrc_applied
        for k in range(len(controls)):
            ctrl[:] = controls[k, :nu]
            force[:] = controls[k, nu:]
            step(model, data, substeps)


def prepare(experiment: str, controller: str) -> tuple[Bench, dict[str, float]]:
    """Load and compile everything as for the second flight, and say how long each took, s.

    The first flight of a controller on a machine is evaluated by CasADi: a compiler would cost more.
    """
    took: dict[str, float] = {}

    def timed(name: str, work: Callable[[], T]) -> T:
        start = time.perf_counter()
        result = work()
        took[name] = time.perf_counter() - start
        return result

    (takeoff,) = timed("robot, controller, scene and mission", lambda: take_off(experiment, (controller,)))
    worth_building(takeoff.tick.function)  # it has been met now
    tick = timed("the tick", lambda: fastest_tick(takeoff))
    timed("references and noise", lambda: takeoff.rows)
    return Bench(takeoff, tick), took


def record_controls(bench: Bench) -> tuple[np.ndarray, np.ndarray]:
    """The controls of every tick of one flight, applied forces behind them, and the state it ends in."""
    here = world(bench.takeoff)
    data, model = here.data, bench.takeoff.plant.model
    controls = np.zeros((len(bench.takeoff.rows), model.nu + model.nv))

    def watch(k: int) -> None:
        controls[k] = np.concatenate([data.ctrl, data.qfrc_applied])

    flight = bench.closed_loop(here, watch)
    if flight.cause:
        raise SystemExit(f"the flight failed: {flight.cause}")
    return controls[: flight.ticks], np.concatenate([data.qpos, data.qvel])


def fastest(repeats: int, *works: Callable[[], float]) -> list[float]:
    """The least time of each work, taken in turns."""
    return [min(times) for times in zip(*([work() for work in works] for _ in range(repeats)), strict=True)]


def time_parts(bench: Bench, repeats: int) -> dict[str, float]:
    """Seconds a tick of each part of the loop, measured one by one on the flight's own numbers."""
    takeoff, tick_function = bench.takeoff, bench.tick
    count, window = bench.ticks, tick_function.window.rows
    data, signals = takeoff.data(), np.zeros(tick_function.signals.size)
    known, references = takeoff.rows.ticks, takeoff.rows.references
    row, reference = known[0].copy(), references[:window].copy()
    log = np.full((count, len(signals)), np.nan)
    state, next_state = tick_function.state.copy(), tick_function.state.copy()
    buffer, evaluate = tick_function.function.buffer()
    plant = (data.qpos, data.qvel, data.act, data.history)
    for i, array in enumerate((state, *plant, row, reference, tick_function.gains)):
        buffer.set_arg(i, array.data)  # pyright: ignore[reportCallIssue]
    for i, array in enumerate((next_state, data.ctrl, signals)):
        buffer.set_res(i, array.data)  # pyright: ignore[reportCallIssue]

    def tick() -> float:
        start = time.perf_counter()
        for _ in range(count):
            evaluate()
        return (time.perf_counter() - start) / count

    def copies() -> float:
        start = time.perf_counter()
        for k in range(count):
            row[:] = known[k]
            reference[:] = references[k : k + window]
            log[k] = signals
        return (time.perf_counter() - start) / count

    def watch() -> float:
        start = time.perf_counter()
        for first in range(0, count, CHECK_INTERVAL):
            flown = Flight(log, tick_function.signals, min(first + CHECK_INTERVAL, count), "")
            find_loss(flown, takeoff.mission, takeoff.experiment.terminations, first)
        return (time.perf_counter() - start) / count

    names = (
        "controller tick (sensors, controller, actuators)",
        "rows in, signals out",
        "watch for a lost flight",
    )
    return dict(zip(names, fastest(repeats, tick, copies, watch), strict=True))


@dataclass(frozen=True)
class Figures:
    """What was measured, s.

    Attributes:
        closed: of a flight.
        raw: of the raw replay of its controls, the engine as its bindings set it up.
        bare: of the same without the engine's timer, which the drivers take away as well.
        parts: of each part of the loop, a tick.
        took: of everything before the flight, once.
    """

    closed: float
    raw: float
    bare: float
    parts: dict[str, float]
    took: dict[str, float]

    @property
    def ratio(self) -> float:
        """Closed loop over raw replay, in speed."""
        return self.raw / self.closed

    @property
    def strict(self) -> float:
        """Closed loop over the replay without the engine's timer, in speed."""
        return self.bare / self.closed

    @property
    def tick(self) -> float:
        """Of the controller's tick, s."""
        return next(iter(self.parts.values()))


def measure(experiment: str, controller: str, repeats: int) -> tuple[Bench, Figures]:
    """Fly, replay, and time both and the parts."""
    bench, took = prepare(experiment, controller)
    controls, end = record_controls(bench)

    def closed_loop() -> float:
        here = world(bench.takeoff)
        start = time.perf_counter()
        bench.closed_loop(here)
        return time.perf_counter() - start

    def replay() -> float:
        data = bench.takeoff.data()
        start = time.perf_counter()
        bench.replay(data, controls)
        elapsed = time.perf_counter() - start
        if not np.array_equal(np.concatenate([data.qpos, data.qvel]), end):
            raise SystemExit("the replay did not end where the flight did: the comparison means nothing")
        return elapsed

    def untimed() -> float:
        with without_timer():
            return replay()

    closed, raw, bare = fastest(repeats, closed_loop, replay, untimed)
    return bench, Figures(closed, raw, bare, time_parts(bench, repeats), took)


def main() -> int:
    """Print what was measured; 1 when it falls short."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--experiment", default="paper")
    parser.add_argument("--controller", default="hybrid")
    parser.add_argument("--repeats", type=int, default=7)
    options = parser.parse_args()
    bench, figures = measure(options.experiment, options.controller, options.repeats)
    report(bench, options, figures)
    return 0 if figures.ratio >= RATIO_WANTED and figures.tick <= TICK_WANTED else 1


def report(bench: Bench, options: argparse.Namespace, figures: Figures) -> None:
    """Print what was measured."""
    closed, raw, parts, took = figures.closed, figures.bare, figures.parts, figures.took
    count, substeps = bench.ticks, bench.takeoff.plant.substeps
    flown = count * bench.takeoff.period
    console = Console(highlight=False)
    console.print(
        f"{options.experiment}, {options.controller}: {flown:.1f} s of flight in {count} ticks of "
        f"{substeps} steps, fastest of {options.repeats}"
    )
    table = Table("", "us a tick", "share", box=None, pad_edge=False)
    for column in table.columns[1:]:
        column.justify = "right"
    rest = closed / count - raw / count - sum(parts.values())
    lines = {
        f"physics ({substeps} steps of MuJoCo)": raw / count,
        **parts,
        "the loop, and caches cold after the physics": rest,
    }
    for name, seconds in lines.items():
        table.add_row(name, f"{1e6 * seconds:.2f}", f"{100 * seconds * count / closed:.1f} %")
    table.add_row("closed loop", f"{1e6 * closed / count:.2f}", f"{flown / closed:.0f} x real time")
    console.print(table)
    tick = figures.tick
    console.print(f"closed loop / raw replay  {figures.ratio:.3f}  (wanted: at least {RATIO_WANTED:.2f})")
    console.print(f"the same without timer    {figures.strict:.3f}")
    console.print(
        f"controller tick           {1e6 * tick:.2f} us  (wanted: at most {1e6 * TICK_WANTED:.0f} us)"
    )
    once = ", ".join(f"{name} {1e3 * seconds:.0f} ms" for name, seconds in took.items())
    console.print(f"once, before the flight: {once}")


if __name__ == "__main__":
    raise SystemExit(main())
