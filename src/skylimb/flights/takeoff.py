"""A flight about to begin: everything that a driver needs, made in one place."""

from __future__ import annotations

import copy
import dataclasses
import functools
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import mujoco
import numpy as np

from skylimb.analysis.own import Own
from skylimb.control.controller import Controller, TraceableController, is_traceable
from skylimb.control.needs import needs_of
from skylimb.errors import ConfigError
from skylimb.experiments.experiment import Experiment
from skylimb.flights.flyable import require_flyable, standing_out
from skylimb.flights.held import require_held
from skylimb.flights.sources import Bundle
from skylimb.missions.configuration import MissionConfig
from skylimb.missions.frame import contact_frame
from skylimb.missions.mission import Mission
from skylimb.missions.plan import plan_mission
from skylimb.missions.posture import posture_plan
from skylimb.missions.table import Window, window_of
from skylimb.planning.posture_path import PostureConfig
from skylimb.robots.model import Robot
from skylimb.simulation.disturbance import Push, PushConfig, body_of, resolved_pushes
from skylimb.simulation.gain_changes import require_gain_changes
from skylimb.simulation.plant import Plant, build_plant, initial_data
from skylimb.simulation.rows import FlightRows, flight_rows
from skylimb.simulation.surface_changes import require_surface_changes, surface_table
from skylimb.simulation.tick import CompiledTick, compile_tick, initial_tick_state


@dataclass(frozen=True)
class Takeoff:
    """A flight about to begin.

    Attributes:
        experiment: what is flown.
        robot: as it is described; plant and nominal posture are made from it.
        controller: what flies it; it may believe in another robot.
        plant: the robot that really flies, and its surface.
        mission: the references of the flight.
        start: the plant's state before the first tick.
        originals: files that its user named, kept for people to read; see `flights.sources`.
        own: metrics and figures of the user's own.
    """

    experiment: Experiment
    robot: Robot
    controller: Controller
    plant: Plant
    mission: Mission
    start: mujoco.MjData
    originals: tuple[Bundle, ...] = ()
    own: tuple[Own, ...] = ()

    @property
    def period(self) -> float:
        """Control period, s."""
        return self.experiment.control_period

    @cached_property
    def window(self) -> Window:
        """Which rows of the mission a tick reads."""
        needs = needs_of(self.controller)
        return window_of(needs.preview, needs.paced, self.period)

    @cached_property
    def times(self) -> np.ndarray:
        """Times since take-off of every tick that the flight may have, s."""
        return self.mission.flight_times(self.window.paced)

    @property
    def count(self) -> int:
        """Ticks that the flight may have."""
        stop_at = self.experiment.stop_at
        return (
            len(self.times) if stop_at is None else max(1, int(np.searchsorted(self.times, stop_at - 1e-9)))
        )

    @property
    def traceable(self) -> bool:
        """Whether sensors, controller and actuators can be compiled to one function."""
        return is_traceable(self.controller)

    @cached_property
    def initial_tick_state(self) -> Any:
        """Sensors, controller and mission clock before the first tick, as a record."""
        return initial_tick_state(self._traced_controller, self.experiment.sensors, self._root, self.period)

    @cached_property
    def tick(self) -> CompiledTick:
        """The compiled tick; only for a controller that can be traced."""
        controller, sensors = self._traced_controller, self.experiment.sensors
        return compile_tick(controller, self.plant, sensors, self._root, self.period)

    @property
    def _traced_controller(self) -> TraceableController:
        if not is_traceable(self.controller):
            raise ConfigError(f"controller '{self.controller.name}' cannot be compiled")
        return self.controller

    @property
    def _root(self) -> np.ndarray:
        """Pose and twist of the root link before take-off, (13,)."""
        return np.concatenate([self.start.qpos[0:7], self.start.qvel[0:6]])

    @cached_property
    def fixed_rows(self) -> FlightRows:
        """References and noise of the whole mission, whatever changes in flight and when it is stopped."""
        experiment = self.experiment
        return flight_rows(self.plant.robot, self.mission, experiment.sensors, experiment.seed, self.window)

    @cached_property
    def rows(self) -> FlightRows:
        """All that is known of the flight beforehand: references, noise, changing gains."""
        rows, changes = self.fixed_rows, self.experiment.gain_changes
        if changes:
            rows = rows.with_changes(changes, self.tick.gains, self.tick.gains_layout, self.period)
        return rows.until(self.count)

    def changed(self, experiment: Experiment) -> Takeoff:
        """The same flight with other changes in flight; all that they do not touch is shared.

        Args:
            experiment: differs from this one in `gain_changes`, `pushes`, `surface_changes` and `stop_at`.

        Raises:
            ConfigError: when a change that is new cannot be.
        """
        require_gain_changes(_new(experiment.gain_changes, self.experiment.gain_changes), self.controller)
        _require_links(_new(experiment.pushes, self.experiment.pushes), self.plant.model)
        changes = _new(experiment.surface_changes, self.experiment.surface_changes)
        require_surface_changes(changes, self.plant.surface, self.plant.model)
        return self._otherwise(experiment=experiment)

    def _otherwise(self, **changes: Any) -> Takeoff:
        other = dataclasses.replace(self, **changes)
        before, after = self.experiment, other.experiment
        shared = [*_SHARED]
        if after.gain_changes is before.gain_changes and after.stop_at == before.stop_at:
            shared.append("rows")
        if after.surface_changes is before.surface_changes:
            shared.append("surface_table")
        vars(other).update({name: vars(self)[name] for name in shared if name in vars(self)})
        return other

    @cached_property
    def pushes(self) -> list[Push]:
        """What pushes the robot in flight."""
        experiment, root = self.experiment, self.plant.robot.description.root
        return resolved_pushes(experiment.disturbance, experiment.pushes, self.plant.model, root, self.times)

    @cached_property
    def surface_table(self) -> np.ndarray | None:
        """What the surface is at every tick; None where it does not change."""
        changes = self.experiment.surface_changes
        return surface_table(changes, self.plant.surface, self.times) if changes else None

    def with_own_model(self) -> Takeoff:
        """The same with a model that no other flight has, for changes of the surface are written into it."""
        return self._otherwise(plant=dataclasses.replace(self.plant, model=copy.copy(self.plant.model)))

    def data(self) -> mujoco.MjData:
        """The plant's state before the first tick, as a copy of its own."""
        data = mujoco.MjData(self.plant.model)
        mujoco.mj_copyData(data, self.plant.model, self.start)
        return data


_SHARED = ("window", "tick", "initial_tick_state", "fixed_rows")
"""What a take-off computes once, and shares with those that differ from it in changes in flight alone."""


def _new(entries: Sequence[Any], before: Sequence[Any]) -> list[Any]:
    """The entries that were not among those before."""
    known = set(map(id, before))
    return [entry for entry in entries if id(entry) not in known]


def _require_links(pushes: Sequence[PushConfig], model: mujoco.MjModel) -> None:
    """Raise an `UnknownNameError` unless the robot has every link that is pushed."""
    for push in pushes:
        if push.link:
            body_of(push.link, model)


def prepare(
    experiment: Experiment,
    robot: Robot,
    controller: Controller,
    originals: tuple[Bundle, ...] = (),
    own: tuple[Own, ...] = (),
) -> Takeoff:
    """Make plant and mission of an experiment, and check everything against each other.

    Args:
        experiment: what to fly.
        robot: the description that plant and nominal posture are made from.
        controller: what flies it.
        originals: files that its user named, for people to read.
        own: metrics and figures of the user's own.

    Raises:
        ConfigError: when a gain that is to change does not exist, when a nominal posture leaves the rotors
            too little, when the robot cannot hold the force that the controller commands, or as
            `plant_and_mission` does.
    """
    require_gain_changes(experiment.gain_changes, controller)
    require_held(experiment, robot, controller)
    plant, mission, start = plant_and_mission(experiment, robot, needs_of(controller).vectoring)
    takeoff = Takeoff(experiment, robot, controller, plant, mission, start, originals, own)
    mission.flight_times(takeoff.window.paced)  # refuses a flight that may take too long
    return takeoff


def plant_and_mission(
    experiment: Experiment, robot: Robot, vectoring: str = "torque"
) -> tuple[Plant, Mission, mujoco.MjData]:
    """The plant and the mission of an experiment, checked against each other, and the plant's first state.

    Args:
        experiment: what to fly.
        robot: the description that plant and nominal posture are made from.
        vectoring: which vectoring angles the nominal posture has (`Needs.vectoring`).

    Raises:
        ConfigError: when the robot would start inside of the surface, its tip does not fit, or the path
            leaves the surface; or a push names a link that the robot does not have.
    """
    dt = experiment.control_period
    plant = build_plant(robot, experiment.surface, experiment.plant, dt)
    _require_links(experiment.pushes, plant.model)
    require_surface_changes(experiment.surface_changes, plant.surface, plant.model)
    mission = mission_of(experiment, robot, vectoring)
    start = initial_data(plant, mission.first)
    require_flyable(plant, mission, start)
    return plant, mission, start


def mission_of(experiment: Experiment, robot: Robot, vectoring: str = "torque") -> Mission:
    """The mission of an experiment; no plant is needed for it. Arguments are those of `plant_and_mission`."""
    dt = experiment.control_period
    config = MissionConfig(
        experiment.phases,
        experiment.approach,
        experiment.trajectory,
        experiment.excitation,
        experiment.wrap,
    )
    plan = (
        config, tuple(experiment.contact_axis), experiment.path_center, experiment.posture,
        robot, vectoring, dt,
    )  # fmt: skip
    # A path that is read from a file may change from one flight to the next.
    shared = experiment.trajectory.shape not in ("drawing", "own") and _is_hashable(plan)
    planned = _planned if shared else _planned.__wrapped__
    mission = planned(*plan)
    clearance = standing_out(experiment.surface, mission)
    return planned(*plan, clearance) if clearance > 0.0 else mission


@functools.lru_cache(maxsize=8)
def _planned(
    config: MissionConfig,
    contact_axis: tuple[float, float, float],
    center: tuple[float, float, float],
    posture: PostureConfig,
    robot: Robot,
    vectoring: str,
    dt: float,
    clearance: float = 0.0,
) -> Mission:
    """The mission of a configuration; flights that differ in noise, plant or surface share one."""
    return plan_mission(
        config,
        contact_frame(contact_axis),
        np.asarray(center, dtype=float),
        posture_plan(posture, robot, vectoring),
        dt,
        clearance,
    )


def _is_hashable(value: Hashable) -> bool:
    try:
        hash(value)
    except TypeError:  # a configuration made in Python may hold lists
        return False
    return True
