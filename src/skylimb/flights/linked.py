"""Fly a robot behind a link: mission, guard and clock here, sensors and actuators there."""

from __future__ import annotations

import dataclasses
import json
import time
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from skylimb.config import to_mapping
from skylimb.control.cascade import calibrated
from skylimb.control.controller import Controller, controller_signals, is_traceable, resolved_tables
from skylimb.control.corrections import Calibrated, corrections_of
from skylimb.control.needs import needs_of
from skylimb.errors import OutputError
from skylimb.experiments.experiment import Experiment, experiment_with, load_experiment, robot_of
from skylimb.flights.drivers.free import FreeDriver
from skylimb.flights.flying import fastest
from skylimb.flights.loading import chosen_controller, parted
from skylimb.flights.on_clock import ClockedFlight, Progress, without_garbage
from skylimb.flights.record import config_units
from skylimb.flights.takeoff import mission_of
from skylimb.loop.flight import Flight, flown_mission
from skylimb.loop.terminations import Stretch, Terminations, distance, tilt
from skylimb.missions.mission import Mission
from skylimb.missions.reference import Reference
from skylimb.realtime.compiled_controller import CompiledController
from skylimb.realtime.guard import GuardedController
from skylimb.realtime.link import Link, LinkedVehicle
from skylimb.realtime.pacer import Pacer
from skylimb.realtime.retreat import BACK, BACK_SPEED, DESCENT
from skylimb.realtime.timing import Timing
from skylimb.realtime.watchdog import Limits
from skylimb.recording.origin import origin_text
from skylimb.recording.run import Run
from skylimb.recording.versions import origin_versions, versions
from skylimb.robots.model import Robot
from skylimb.signals import Signal
from skylimb.simulation.log import log_variable

PATIENCE = 5.0
"""Seconds that the first measurement is waited for."""


def fly_linked(
    link: Link,
    experiment: str | Experiment = "paper",
    controller: str | Controller | None = None,
    set: Mapping[str, Any] | None = None,
    limits: Limits | None = None,
    pacer: Pacer | None = None,
    patience: float = PATIENCE,
    progress: Progress | None = None,
    calibration: Calibrated | None = None,
) -> ClockedFlight:
    """Fly the mission of an experiment with a robot that hovers behind a link; at its end the robot lands.

    Commands stop when it has landed. A robot has to do something sensible when they stop at any time.

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

    Returns:
        A run without truth and scores: measurements, commands, and all that the controller records.

    Raises:
        OutputError: when no measurement comes.
    """
    settings, gains = parted(set or {})
    experiment = (
        experiment_with(experiment, settings)
        if isinstance(experiment, Experiment)
        else load_experiment(experiment, settings)
    )
    robot = robot_of(experiment)
    chosen = chosen_controller(controller, experiment, robot, gains)
    if calibration is not None:
        chosen = calibrated(chosen, robot, corrections_of(calibration), gains)
    clock = pacer or Pacer(experiment.control_period)
    inner: Any = CompiledController(chosen, clock.period, fastest) if is_traceable(chosen) else chosen
    guard = GuardedController(inner, robot, clock, limits)
    vehicle = LinkedVehicle(robot, link, clock.clock, lambda time: guard.taken(time - clock.started))
    mission = mission_of(experiment, robot, needs_of(chosen).vectoring)
    flight, whole = _fly(guard, vehicle, robot, mission, experiment.terminations, clock, patience, progress)
    run = _run(flight, whole, experiment, robot, chosen)
    late, latency, held = (flight.signal(name) for name in ("tick_late", "tick_latency", "tick_held"))
    timing = Timing(clock.period, late, latency, held > 0.0)
    faults = {**guard.counts, **guard.watchdog.counts, **vehicle.counts}
    return ClockedFlight(run, timing, faults)


def _fly(
    guard: GuardedController,
    vehicle: LinkedVehicle,
    robot: Robot,
    mission: Mission,
    limits: Terminations,
    clock: Pacer,
    patience: float,
    progress: Progress | None,
) -> tuple[Flight, Mission]:
    """The flight up to its landing, and the mission with time to land."""
    last, total = len(mission.times) - 1, len(mission.flight_times(guard.needs.paced))
    landing = BACK / BACK_SPEED + max(0.0, float(mission.reference.position[-1, 2])) / DESCENT
    extra = int(np.ceil(landing / clock.period))
    whole = _with_rest(mission, total - last - 1 + extra)
    driver = FreeDriver(guard, vehicle, robot, whole, total + extra)
    _wait_for(vehicle, clock, patience)
    every, done, cause = round(1.0 / clock.period), 0, ""
    with without_garbage():
        clock.start(clock.period)
        for k in range(total + extra):
            clock.wait(k)
            at, done = driver.tick(k), k + 1
            if guard.retreating:
                cause = cause or ("broken off by the guard" if at <= last else "")
                extra -= 1
                if extra <= 0:
                    break
            elif at > last or k + 1 >= total:
                guard.retreat()
                at = last + 1
            else:
                lost = _lost(driver, whole, limits, k, at)
                if lost:
                    guard.retreat(lost)
                    cause = lost
            if progress is not None and done % every == 0:
                progress(min(at, last + 1), last + 1)
    return Flight(driver.log, driver.layout, done, cause), whole


def _wait_for(vehicle: LinkedVehicle, clock: Pacer, patience: float) -> None:
    """Return once a measurement has come."""
    end = time.monotonic() + patience
    clock.start()
    while True:
        vehicle.greet()
        vehicle.measure()
        if vehicle.heard:
            return
        if time.monotonic() > end:
            heard = ", ".join(f"{what} {count} times" for what, count in vehicle.counts.items())
            raise OutputError(f"no measurement came within {patience:g} s ({heard or 'nothing was heard'})")
        time.sleep(clock.period)


def _lost(driver: FreeDriver, mission: Mission, limits: Terminations, k: int, at: int) -> str:
    """Why the flight is lost by what was measured at tick `k`; empty while it is not."""
    row, places = driver.log[k], driver.layout.slices
    position = row[places["root_position_measured"]][None]
    quaternion = row[places["root_quaternion_measured"]][None]
    if not (np.isfinite(position).all() and np.isfinite(quaternion).all()):
        return ""  # the watchdog's affair
    reference = mission.reference.position[min(at, len(mission.times) - 1)][None]
    seen = Stretch(position, quaternion, reference, np.array([True]))
    found = [words for check in (tilt, distance) for lost, words in [check(seen, limits)] if lost[0]]
    return found[0] if found else ""


def _with_rest(mission: Mission, ticks: int) -> Mission:
    """The mission with its last row for some ticks more."""

    def longer(entry: np.ndarray) -> np.ndarray:
        return np.concatenate([entry, np.repeat(entry[-1:], ticks, axis=0)])

    reference, held = mission.reference, Reference._fields[:-1]
    return dataclasses.replace(
        mission,
        times=np.arange(len(mission.times) + ticks) * mission.period,
        reference=reference._replace(**{name: longer(getattr(reference, name)) for name in held}),
        phase=longer(mission.phase),
        tip_path=longer(mission.tip_path),
    )


def _run(
    flight: Flight, mission: Mission, experiment: Experiment, robot: Robot, controller: Controller
) -> Run:
    """What is known of the flight, as a run."""
    count, description = flight.ticks, robot.description
    flown = flown_mission(mission, flight)
    own = controller_signals(controller)
    values = {name: flight.signal(name) for name in flight.layout.slices}
    values |= {
        "cog_position_reference": flown.reference.position[:count],
        "cog_velocity_reference": flown.reference.velocity[:count],
        "cog_acceleration_reference": flown.reference.acceleration[:count],
        "reach_reference": flown.reference.reach[:count],
        "tip_position_reference": flown.reference.tip_position[:count],
        "phase": flown.phase[:count].astype(np.int8),
    }
    config = to_mapping({**experiment.to_mapping(), "controller": resolved_tables(controller)})
    config.pop("recorded", None)
    log = xr.Dataset(
        {name: log_variable(name, array, own.get(name, Signal())) for name, array in values.items()},
        {
            "time": ("time", np.arange(count) * mission.period, {"units": "s", "long_name": "time"}),
            "axis": ["x", "y", "z"],
            "quaternion": ["w", "x", "y", "z"],
            "rotor": [rotor.name for rotor in description.rotors],
            "joint": list(description.shape_joints),
            "vectoring": list(description.vectoring_joints),
        },
        {
            "robot": robot.name,
            "experiment": experiment.name,
            "controller": controller.name,
            "status": "FAILED" if flight.cause else "OK",
            "cause": flight.cause,
            "contact_axis": mission.frame.contact.tolist(),
            "sliding_axes": [*mission.frame.sliding_u.tolist(), *mission.frame.sliding_v.tolist()],
            "config": origin_text(config, {}, origin_versions()),
            "config_units": json.dumps(config_units(experiment, controller)),
            "versions": json.dumps(versions()),
        },
    )
    return Run(name=controller.name, controller=controller.name, log=log)
