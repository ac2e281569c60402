"""Fly an experiment: put plant, sensors, mission and controller together and hand back a run."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from skylimb.analysis.metrics import metrics
from skylimb.config import write_toml
from skylimb.control.cascade import Cascade
from skylimb.control.controller import (
    Controller,
    controller_from_tables,
    load_controller,
    resolved_preset,
)
from skylimb.errors import ConfigError
from skylimb.experiments.asked_line import with_asked_line
from skylimb.experiments.experiment import Experiment, experiment_with, load_experiment
from skylimb.experiments.flyable import first_row, require_flyable, standing_out
from skylimb.experiments.posture_plan import posture_plan
from skylimb.recording.run import Run
from skylimb.recording.versions import versions
from skylimb.robots.loader import load_robot
from skylimb.robots.model import Robot
from skylimb.simulation.drivers import fly_compiled, interventions, mission_rows
from skylimb.simulation.flight import Flight
from skylimb.simulation.gain_changes import require_gain_changes
from skylimb.simulation.log import flight_log
from skylimb.simulation.mission import Mission, MissionConfig, contact_frame, plan_mission
from skylimb.simulation.plant import Plant, build_plant, initial_data
from skylimb.simulation.python_driver import fly_python
from skylimb.simulation.tick import compile_tick

Progress = Callable[[str, int, int], None]
"""Called now and then with (controller, ticks flown, ticks in all)."""

DEFAULT_CONTROLLER = "hybrid"
PAPER_CONTROLLERS = ("pid", "impedance", "admittance", "hybrid")


def run(
    experiment: str | Experiment = "paper",
    controller: str | Controller | None = None,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
) -> Run:
    """Fly one controller through one experiment.

    Args:
        experiment: a name, a TOML file, or an experiment at hand.
        controller: a preset's name, a preset's TOML file, a Python file, or a controller at hand; when
            None, the one that the experiment's file brings along (as a run's config.toml does), else
            "hybrid".
        seed: of the sensors' noise; the experiment's own when None.
        set: dotted keys of the experiment and new values; keys that begin with "controller." go to the
            preset.
        progress: told how far the flight is.

    Returns:
        The run; a flight that is lost has status FAILED and its cause, and no scores.

    Raises:
        SkylimbError: when anything asked for cannot be flown; nothing has flown then.
    """
    flown, robot, controllers = _prepare(experiment, (controller,), seed, set)
    return fly(flown, robot, controllers[0], progress)


def compare(
    experiment: str | Experiment = "paper",
    controllers: Sequence[str | Controller] = PAPER_CONTROLLERS,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
) -> dict[str, Run]:
    """Fly several controllers through the same experiment with the same seed.

    Arguments are those of `run`.

    Returns:
        Runs by the controllers' names, in the order given.
    """
    flown, robot, ready = _prepare(experiment, controllers, seed, set)
    names = [controller.name for controller in ready]
    alike = sorted({name for name in names if names.count(name) > 1})
    if alike:
        raise ConfigError(f"two controllers are called '{alike[0]}'; a comparison needs a name for each")
    return {controller.name: fly(flown, robot, controller, progress) for controller in ready}


def _prepare(
    experiment: str | Experiment,
    controllers: Sequence[str | Controller | None],
    seed: int | None,
    set: Mapping[str, Any] | None,
) -> tuple[Experiment, Robot, list[Controller]]:
    """Load and check everything before anything flies."""
    given = dict(set or {})
    gains = {
        key.removeprefix("controller."): given.pop(key)
        for key in list(given)
        if key.startswith("controller.")
    }
    if seed is not None:
        given["seed"] = seed
    if isinstance(experiment, Experiment):
        experiment = experiment_with(experiment, given)
    else:
        experiment = load_experiment(experiment, given)
    robot = load_robot(experiment.robot)
    ready = [_controller(item, experiment, robot, gains) for item in controllers]
    for controller in ready:
        require_gain_changes(experiment.gain_changes, controller)
    return experiment, robot, ready


def _controller(
    given: str | Controller | None, experiment: Experiment, robot: Robot, gains: Mapping[str, Any]
) -> Controller:
    if given is None and experiment.controller:
        # A user's own Python controller leaves only its name behind.
        if set(experiment.controller) == {"name"}:
            raise ConfigError(
                f"experiment {experiment.name} was flown by '{experiment.controller['name']}', a Python "
                "controller that its file does not hold; name it with --controller"
            )
        return controller_from_tables(experiment.controller, Path("config.toml"), robot, gains)
    if given is None or isinstance(given, str):
        return load_controller(given or DEFAULT_CONTROLLER, robot, gains)
    return given


def fly(
    experiment: Experiment, robot: Robot, controller: Controller, progress: Progress | None = None
) -> Run:
    """Fly a loaded controller through a loaded experiment.

    Args:
        experiment: what to fly.
        robot: the description that plant and nominal posture are made from.
        controller: any object that follows `Controller`; it may believe in another robot.
        progress: told how far the flight is.
    """
    plant, mission = prepare_flight(experiment, robot, vectoring_purpose(controller))
    flight = fly_mission(experiment, plant, mission, controller, progress)
    return recorded(experiment, robot, controller, plant, mission, flight)


def recorded(
    experiment: Experiment,
    robot: Robot,
    controller: Controller,
    plant: Plant,
    mission: Mission,
    flight: Flight,
) -> Run:
    """A flight as a run: its log with everything that produced it, and its scores."""
    run = scored(experiment, robot, controller, plant, mission, flight)
    return documented(run, experiment, controller, plant)


def scored(
    experiment: Experiment,
    robot: Robot,
    controller: Controller,
    plant: Plant,
    mission: Mission,
    flight: Flight,
) -> Run:
    """A flight as a run with its scores; `documented` adds what only a record that is kept needs."""
    log = with_asked_line(flight_log(plant, flight, mission), experiment.trajectory)
    frame = mission.frame
    log.attrs |= {
        "robot": robot.name,
        "experiment": experiment.name,
        "controller": controller.name,
        "seed": experiment.seed,
        "status": "FAILED" if flight.cause else "OK",
        "cause": flight.cause,
        "surface": json.dumps(plant.surface.describe()),
        "contact_axis": frame.contact.tolist(),
        "sliding_axes": [*frame.sliding_u.tolist(), *frame.sliding_v.tolist()],
        "path_center": json.dumps([float(x) for x in experiment.surface.position]),
    }
    return Run(name=controller.name, controller=controller.name, log=log, metrics=metrics(log))


def documented(run: Run, experiment: Experiment, controller: Controller, plant: Plant) -> Run:
    """The run with all that produced it in its log: configuration, versions and scene."""
    config = {**experiment.to_mapping(), "controller": resolved_preset(controller)}
    log = run.log.assign_attrs(config=write_toml(config), versions=json.dumps(versions()), scene=plant.scene)
    return dataclasses.replace(run, log=log)


def vectoring_purpose(controller: Controller) -> str:
    """Which vectoring angles a controller takes off with; "torque", the paper's, unless it says otherwise."""
    if isinstance(controller, Cascade):
        return controller.preset.vectoring.purpose
    return str(getattr(controller, "vectoring_purpose", "torque"))


def prepare_flight(experiment: Experiment, robot: Robot, purpose: str = "torque") -> tuple[Plant, Mission]:
    """The plant and the mission of an experiment, checked against each other.

    Args:
        experiment: what to fly.
        robot: the description that plant and nominal posture are made from.
        purpose: of the vectoring angles in the nominal posture.

    Raises:
        ConfigError: when the robot would start inside the surface, its tip does not fit, or the path
            leaves it.
    """
    dt = experiment.control_period
    plant = build_plant(robot, experiment.surface, experiment.plant, dt)
    asked = (
        MissionConfig(experiment.phases, experiment.approach, experiment.trajectory),
        contact_frame(experiment.contact_axis),
        np.asarray(experiment.surface.position, dtype=float),
        posture_plan(experiment.posture, robot, purpose),
        dt,
    )
    mission = plan_mission(*asked)
    clearance = standing_out(plant.surface, mission)
    if clearance > 0.0:
        mission = plan_mission(*asked, clearance)
    require_flyable(plant, mission)
    return plant, mission


def fly_mission(
    experiment: Experiment,
    plant: Plant,
    mission: Mission,
    controller: Controller,
    progress: Progress | None = None,
) -> Flight:
    """Fly with the driver that suits the controller."""
    dt = experiment.control_period
    require_gain_changes(experiment.gain_changes, controller)
    data = initial_data(plant, first_row(mission))
    paced = bool(getattr(controller, "paced", False))
    rows = mission_rows(plant, mission, experiment.sensors, experiment.seed, paced)
    outside = interventions(plant, data, mission.flight_times(paced), experiment.disturbance)

    def report(done: int, total: int) -> None:
        if progress is not None:
            progress(controller.name, done, total)

    if isinstance(controller, Cascade):
        root = np.concatenate([data.qpos[0:7], data.qvel[0:6]])
        tick = compile_tick(controller, plant, experiment.sensors, root, dt)
        rows = rows.with_changes(experiment.gain_changes, tick, dt)
        return fly_compiled(tick, plant, data, mission, rows, outside, report)
    return fly_python(controller, plant, data, mission, rows, experiment.sensors, dt, outside, report)
