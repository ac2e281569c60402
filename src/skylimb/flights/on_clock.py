"""A flight on the wall clock: a simulated plant in place of a robot, guard and pacer as on a robot."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from skylimb.analysis.own import with_own_scores
from skylimb.control.controller import Controller
from skylimb.control.corrections import Calibrated
from skylimb.experiments.experiment import Experiment
from skylimb.flights.drivers.free import FreeDriver
from skylimb.flights.flying import fastest
from skylimb.flights.loading import take_off
from skylimb.flights.record import recorded
from skylimb.flights.takeoff import Takeoff
from skylimb.loop.flight import Flight
from skylimb.loop.loop import Loop
from skylimb.realtime.compiled_controller import CompiledController
from skylimb.realtime.guard import GuardedController
from skylimb.realtime.pacer import Pacer
from skylimb.realtime.timing import Timing
from skylimb.realtime.watchdog import Limits
from skylimb.recording.run import Run
from skylimb.simulation.engine_timer import without_timer
from skylimb.simulation.interventions import interventions
from skylimb.simulation.vehicle import SimulatedVehicle

Progress = Callable[[int, int], None]
"""Called once a second with (ticks of the mission flown, ticks in all)."""


@dataclass(frozen=True)
class ClockedFlight:
    """A flight on the wall clock.

    Attributes:
        run: as of any flight, with `tick_late`, `tick_latency`, `tick_held` and `retreating` in its log.
        timing: how it kept to the clock.
        faults: how often each fault was met, by name.
    """

    run: Run
    timing: Timing
    faults: Mapping[str, int]


def fly_on_clock(
    experiment: str | Experiment = "paper",
    controller: str | Controller | None = None,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    limits: Limits | None = None,
    pacer: Callable[[float], Pacer] = Pacer,
    progress: Progress | None = None,
    calibration: Calibrated | None = None,
) -> ClockedFlight:
    """Fly a simulated plant on the wall clock, under the guard that flies a robot.

    A tick that begins when the next one is due holds its command; after `limits.overruns` such ticks in a row
    the flight retreats from the surface.

    Args:
        experiment: as of `skylimb.run`, and so are controller, seed and set.
        controller: see there.
        seed: see there.
        set: see there.
        limits: when to hold and when to retreat.
        pacer: makes the pacer for a control period, s.
        progress: called with how far the flight is.
        calibration: as of `skylimb.run`.
    """
    (takeoff,) = take_off(experiment, (controller,), seed, set, calibration=calibration)
    clock = pacer(takeoff.period)
    guard = guarded(takeoff, clock, limits)
    with without_timer():
        loop = _loop(takeoff, guard)
        flight = _fly(loop, clock, progress)
    run = with_own_scores(recorded(takeoff, flight), takeoff.own)
    late, latency, held = (flight.signal(name) for name in ("tick_late", "tick_latency", "tick_held"))
    timing = Timing(takeoff.period, late, latency, held > 0.0)
    return ClockedFlight(run, timing, {**guard.counts, **guard.watchdog.counts})


def guarded(takeoff: Takeoff, clock: Pacer | None, limits: Limits | None = None) -> GuardedController:
    """The controller of a take-off, compiled where it can be, under its guard."""
    controller: Any = takeoff.controller
    if takeoff.traceable:
        controller = CompiledController(controller, takeoff.period, fastest)
    return GuardedController(controller, takeoff.robot, clock, limits)


def _loop(takeoff: Takeoff, controller: Controller) -> Loop:
    plant, data, rows = takeoff.plant, takeoff.data(), takeoff.rows
    outside = interventions(plant, data, takeoff.times, takeoff.pushes)
    vehicle = SimulatedVehicle(
        plant, data, rows.ticks, takeoff.experiment.sensors, takeoff.period, outside, fastest
    )
    driver = FreeDriver(controller, vehicle, plant.robot, takeoff.mission, len(rows))
    return Loop(driver, takeoff.mission, takeoff.experiment.terminations, len(takeoff.times))


def _fly(loop: Loop, clock: Pacer, progress: Progress | None) -> Flight:
    """Tick by tick, each when it is due."""
    total, every, k = len(loop.mission.times), round(1.0 / clock.period), 0
    with without_garbage():
        clock.start(clock.period)
        while True:
            clock.wait(k)
            if not loop.tick():
                return loop.finish()
            k += 1
            if progress is not None and k % every == 0:
                progress(min(k, total), total)


@contextmanager
def without_garbage() -> Iterator[None]:
    """No pause for collecting garbage; what is there already is not looked at again."""
    enabled = gc.isenabled()
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        yield
    finally:
        gc.unfreeze()
        if enabled:
            gc.enable()
