"""A flight on the wall clock: a simulated plant in place of a robot, guard and pacer as on a robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from skylimb.analysis.scores.user_scores import with_user_scores
from skylimb.control.controller import Controller
from skylimb.control.corrections import Calibrated
from skylimb.control.loop.flight import Flight
from skylimb.control.loop.loop import Loop
from skylimb.flight.drivers.free import FreeDriver
from skylimb.flight.drivers.world import world
from skylimb.flight.experiments.experiment import Experiment
from skylimb.flight.flying import simulated_vehicle
from skylimb.flight.guarded import ClockedFlight, Progress, guarded, timing_of, without_garbage
from skylimb.flight.realtime.pacer import Pacer
from skylimb.flight.realtime.watchdog import Limits
from skylimb.flight.record import recorded
from skylimb.flight.takeoff import Takeoff, take_off
from skylimb.simulation.engine_timer import without_timer


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
    guard = guarded(takeoff.plan, clock, limits)
    with without_timer():
        loop = _loop(takeoff, guard)
        flight = _fly(loop, clock, progress)
    run = with_user_scores(recorded(takeoff, flight), takeoff.plan.own)
    return ClockedFlight(run, timing_of(flight, takeoff.period), {**guard.counts, **guard.watchdog.counts})


def _loop(takeoff: Takeoff, controller: Controller) -> Loop:
    here, rows = world(takeoff), takeoff.rows
    vehicle = simulated_vehicle(takeoff, here, rows.ticks)
    driver = FreeDriver(controller, vehicle, here.plant.robot, takeoff.mission, len(rows), here.events.gains)
    return Loop(driver, takeoff.mission, takeoff.experiment.terminations, takeoff.count)


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
