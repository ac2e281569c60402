"""A flight on the wall clock: a simulated plant in place of a robot, guard and pacer as on a robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from skylimb.analysis.exchange.recorder import FlightRecorder
from skylimb.control.controller import Controller
from skylimb.control.corrections import Calibrated
from skylimb.control.loop.loop import Loop, Progress
from skylimb.control.supervisor.limits import Limits
from skylimb.flight.drivers.free import FreeDriver
from skylimb.flight.drivers.world import world
from skylimb.flight.experiments.experiment import Experiment
from skylimb.flight.flying import simulated_vehicle
from skylimb.flight.realtime.clocked_flight import (
    ClockedFlight,
    each_second,
    guarded_controller,
    ticks_on_clock,
    timing_of,
)
from skylimb.flight.realtime.pacer import Pacer
from skylimb.flight.recorded_ticks import RecordedTicks
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import take_off
from skylimb.simulation.engine_timer import without_timer


def fly_on_clock(
    experiment: str | Experiment = "paper",
    controller: str | Controller | None = None,
    set: Mapping[str, Any] | None = None,
    limits: Limits | None = None,
    pacer: Callable[[float], Pacer] = Pacer,
    progress: Progress | None = None,
    calibration: Calibrated | None = None,
    recorder: FlightRecorder | None = None,
) -> ClockedFlight:
    """Fly a simulated plant on the wall clock, under the guard that flies a robot.

    A tick that begins when the next one is due holds its command; after `limits.overruns` such ticks in a row
    the flight retreats from the surface.

    Args:
        experiment: as of `skylimb.run`, and so are controller and set.
        controller: see there.
        set: see there.
        limits: when to hold and when to retreat.
        pacer: makes the pacer for a control period, s.
        progress: called once a second with (ticks of the mission flown, ticks in all).
        calibration: as of `skylimb.run`.
        recorder: keeps the flight on the disk as it is flown.
    """
    (takeoff,) = take_off(experiment, (controller,), set=set, calibration=calibration)
    clock = pacer(takeoff.period)
    guard = guarded_controller(takeoff, clock, limits)
    mission, rows, simulated = takeoff.mission, takeoff.rows, world(takeoff)
    with without_timer():
        vehicle = simulated_vehicle(takeoff, simulated)
        driver = FreeDriver(guard, vehicle, simulated.plant.robot, mission, len(rows), simulated.events.gains)
        loop = Loop(driver, mission, takeoff.experiment.terminations, takeoff.count)
        driver.prepare(guard.rehearsed(driver.first, takeoff.period))
        ticks = RecordedTicks(recorder, takeoff, driver.layout)
        ticks.begin()
        for k in ticks_on_clock(clock):
            going = loop.tick()
            if loop.ticks > k:
                ticks.flown(k, driver.log[k])
            if not going:
                break
            each_second(clock, progress, k + 1, k + 1, len(mission.times))
    flight = loop.stop()
    return ClockedFlight(
        scored_run(takeoff, flight),
        timing_of(flight, takeoff.period),
        {**guard.counts, **ticks.faults},
    )
