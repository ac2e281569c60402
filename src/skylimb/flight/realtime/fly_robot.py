"""Fly a robot behind a link: mission, guard and clock here, sensors and actuators there."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from skylimb.analysis.exchange.recorder import FlightRecorder
from skylimb.base.aside import UNREAD, said_aside
from skylimb.base.errors import ConfigError
from skylimb.base.interrupts import ENDS, answering_first, unfrozen
from skylimb.control.controller import Controller
from skylimb.control.corrections import Calibrated
from skylimb.control.loop.flight import Flight, flown_mission, mission_signals
from skylimb.control.loop.loop import Progress
from skylimb.control.loop.terminations import Stretch, Terminations, distance, tilt
from skylimb.control.missions.clock import Clock
from skylimb.control.missions.mission import Mission
from skylimb.control.supervisor.descents import unprotected
from skylimb.control.supervisor.limits import Limits
from skylimb.flight.drivers.free import FreeDriver
from skylimb.flight.events import CONTROLLER_KINDS, require_applied
from skylimb.flight.experiments.experiment import Experiment
from skylimb.flight.flight_run import documented, flight_run
from skylimb.flight.loading import plan_flights
from skylimb.flight.plan import FlightPlan
from skylimb.flight.realtime.clocked_flight import (
    ClockedFlight,
    each_second,
    guarded_controller,
    ticks_on_clock,
    timing_of,
    without_garbage,
)
from skylimb.flight.realtime.guard import GuardedController
from skylimb.flight.realtime.landed import Landed
from skylimb.flight.realtime.landing import DEPTH, landing_from
from skylimb.flight.realtime.link import Link, RemoteVehicle
from skylimb.flight.realtime.look import Look, measured_at
from skylimb.flight.realtime.pacer import Pacer
from skylimb.flight.realtime.preflight import LOOK, Check, StartLimits
from skylimb.flight.recorded_ticks import RecordedTicks

PATIENCE = 5.0
"""Seconds that the first measurement is waited for."""

LISTEN = 0.2
"""Seconds for which a robot is looked at before it is flown."""

ENDED = "ended by its user"
"""Why a flight is broken off that Ctrl-C, or the system, ends."""


def fly_robot(
    link: Link,
    experiment: str | Experiment = "paper",
    controller: str | Controller | None = None,
    set: Mapping[str, Any] | None = None,
    limits: Limits | None = None,
    pacer: Pacer | None = None,
    patience: float = PATIENCE,
    progress: Progress | None = None,
    calibration: Calibrated | None = None,
    recorder: FlightRecorder | None = None,
    listen: float = LISTEN,
    start: StartLimits | None = None,
) -> ClockedFlight:
    """Fly the mission of an experiment with a robot that hovers behind a link; at its end the robot lands.

    Commands stop when it has landed (`landing`). Ctrl-C, or the end that the system asks for, lands it too; a
    second one stops the commands. So does a terminal that goes away, however often; Ctrl-Z does nothing. Who
    reads what is said holds up no tick. What is raised in flight, also by `progress`, is raised once it has
    landed. A robot has to do something sensible when commands stop at any time.

    Args:
        link: to the robot.
        experiment: gives robot, mission, rate, and the limits of tilt and distance.
        controller: as of `skylimb.run`.
        set: dotted keys and new values.
        limits: when to hold and when to retreat.
        pacer: of the ticks; the wall clock by default.
        patience: how long the first measurement is waited for, s.
        progress: called once a second with how far the flight is.
        calibration: as of `skylimb.run`.
        recorder: keeps the flight on the disk as it is flown.
        listen: for how long the robot is looked at before it is flown, s.
        start: with what a flight begins, and the fence that it stays in.

    Returns:
        A run without truth and scores: measurements, commands, and all that the controller records.

    Raises:
        OutputError: when no measurement comes.
        ConfigError: when something is found that no flight begins with; see `preflight`.
    """
    (plan,) = plan_flights(experiment, (controller,), None, set, calibration=calibration)
    require_applied(plan.experiment.events, CONTROLLER_KINDS, "a robot behind a link")
    clock = pacer or Pacer(plan.period)
    limits = limits or plan.experiment.supervisor
    guard = guarded_controller(plan, clock, replace(limits, floor=limits.floor - DEPTH))
    vehicle = RemoteVehicle(
        plan.robot, link, clock.clock, lambda time: guard.taken(time, time), plan.needs.imu
    )
    told = unprotected(plan.robot, plan.needs.vectoring, limits)
    first, begins = plan.mission.first, start or StartLimits()
    look = Look(plan.robot, vehicle, clock, first, begins, calibration, patience, told)
    with said_aside() as words, without_garbage():
        flight, whole, kept = _fly(
            plan, guard, vehicle, clock, progress, recorder, look, listen, limits.floor
        )
    values = {name: flight.signal(name) for name in flight.layout.slices}
    values |= mission_signals(flown_mission(whole, flight), flight.ticks)
    times = np.arange(flight.ticks) * plan.period
    run = documented(flight_run(plan, values, times, flight.cause), plan)
    faults = {**guard.counts, **vehicle.counts, **kept, **({UNREAD: words.lost} if words.lost else {})}
    return ClockedFlight(run, timing_of(flight, plan.period), faults)


def _fly(
    plan: FlightPlan,
    guard: GuardedController,
    vehicle: RemoteVehicle,
    clock: Pacer,
    progress: Progress | None,
    recorder: FlightRecorder | None,
    look: Look,
    listen: float,
    floor: float,
) -> tuple[Flight, Mission, Mapping[str, int]]:
    """The flight up to its landing, the mission with time to land, and the faults of its record."""
    mission, limits = plan.mission, plan.experiment.terminations
    last, total = len(mission.times) - 1, len(mission.flight_times(guard.needs.paced))
    highest = float(mission.reference.position[:, 2].max())
    # The mission's last row goes on while the robot lands, from wherever it is broken off.
    count = total + int(np.ceil(landing_from(highest, floor).longest / clock.period))
    whole = mission.along(Clock(np.arange(float(count)), np.ones(count)))
    events = plan.timeline(np.arange(count) * plan.period)
    first = mission.first
    posed = plan.robot.at(np.asarray(first.joint_angles), np.asarray(first.vectoring_angles))
    hover = float(np.sum(np.asarray(posed.hover_thrusts)))
    driver = FreeDriver(guard, vehicle, plan.robot, whole, count, events.gains)
    driver.prepare(guard.rehearsed(driver.first, plan.period))
    ticks = RecordedTicks(recorder, plan, driver.layout)
    if wrong := [str(one) for one in look.found(listen) if not one.fine]:
        raise ConfigError(f"nothing is flown: {'; '.join(wrong)}")
    ticks.begin()
    due, landing = ticks_on_clock(clock), Landed(guard, driver, look, hover, floor)
    flown, cause, ended = 0, "", list[int]()
    with answering_first(ENDS, lambda number, _: ended.append(number)), unfrozen():
        try:
            for k in due:
                guard.delayed(vehicle.loop_delay)
                if stood := clock.stood_still(guard.limits.overruns):
                    guard.wake()
                at, flown = driver.tick(k), k + 1
                if stood:
                    clock.forgive()
                ticks.flown(k, driver.log[k])
                seen = measured_at(driver, k)
                if guard.retreating:
                    landing.next(seen, driver.log[k][driver.layout.slices["thrusts_command"]], clock.period)
                    cause = cause or (guard.reason if at <= last else "")
                elif at > last or flown >= total:
                    guard.retreat()  # the mission is over: land
                elif lost := _ended(ended) or _lost(driver, whole, limits, k, at) or look.left(seen):
                    guard.retreat(lost)
                    cause = lost
                if flown >= count or landing.over:
                    break
                each_second(clock, progress, flown, at, last + 1)
        except (Exception, SystemExit) as error:
            landing.without_log(due, clock.period, error)
            raise
    return Flight(driver.log, driver.layout, flown, cause), whole, ticks.faults


def check_robot(
    link: Link,
    experiment: str | Experiment = "paper",
    set: Mapping[str, Any] | None = None,
    calibration: Calibrated | None = None,
    start: StartLimits | None = None,
) -> list[Check]:
    """Look at a robot for some seconds, and command nothing; arguments are those of `fly_robot`.

    Raises:
        OutputError: when no measurement comes.
    """
    (plan,) = plan_flights(experiment, (None,), None, set, calibration=calibration)
    clock = Pacer(plan.period)
    vehicle = RemoteVehicle(plan.robot, link, clock.clock)
    told = unprotected(plan.robot, plan.needs.vectoring, plan.experiment.supervisor)
    first, limits = plan.mission.first, start or StartLimits()
    return Look(plan.robot, vehicle, clock, first, limits, calibration, PATIENCE, told).found(LOOK)


def _ended(signals: list[int]) -> str:
    """Why the flight is broken off that its user ends; empty while nobody does. Who waits for it sees it."""
    if not signals:
        return ""
    warnings.warn(f"{ENDED}: the robot is led back and down; Ctrl-C again stops its commands", stacklevel=2)
    return ENDED


def _lost(driver: FreeDriver, mission: Mission, limits: Terminations, k: int, at: int) -> str:
    """Why the flight is lost by what was measured at tick `k`; empty while it is not."""
    row, places = driver.log[k], driver.layout.slices
    position = row[places["root_position_measured"]][None]
    quaternion = row[places["root_quaternion_measured"]][None]
    if not (np.isfinite(position).all() and np.isfinite(quaternion).all()):
        return ""  # the watchdog sees to that
    reference = mission.reference.position[min(at, len(mission.times) - 1)][None]
    seen = Stretch(position, quaternion, reference, np.array([True]))
    found = [words for check in (tilt, distance) for lost, words in [check(seen, limits)] if lost[0]]
    return found[0] if found else ""
