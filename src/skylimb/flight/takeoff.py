"""A simulated flight about to begin: its plan with a plant, and everything that a driver needs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from skylimb.analysis.scores.user_scores import UserScore
from skylimb.base.errors import ConfigError
from skylimb.control.controller import Controller, TraceableController, is_traceable
from skylimb.control.corrections import Calibrated
from skylimb.control.missions.mission import Mission
from skylimb.control.missions.table import Window
from skylimb.flight.events import SurfaceChange, Timeline, require_events
from skylimb.flight.events.surface import surface_table
from skylimb.flight.experiments.experiment import Experiment
from skylimb.flight.loading import Use, plan_flights
from skylimb.flight.plan import FlightPlan, plan_flight
from skylimb.flight.sources import Bundle
from skylimb.robots.model import Robot
from skylimb.simulation.plant import Plant, build_plant, initial_data
from skylimb.simulation.robot_bodies import TIP_SITE
from skylimb.simulation.rows import FlightRows, flight_rows
from skylimb.simulation.surfaces import require_clear
from skylimb.simulation.tick import CompiledTick, compile_tick, initial_tick_state


@dataclass(frozen=True)
class Takeoff:
    """A simulated flight about to begin. Nothing writes into it or into what it holds.

    Attributes:
        plan: what is flown, and by what.
    """

    plan: FlightPlan

    @property
    def experiment(self) -> Experiment:
        """What is flown."""
        return self.plan.experiment

    @property
    def robot(self) -> Robot:
        """As it is described; plant and nominal posture are made from it."""
        return self.plan.robot

    @property
    def controller(self) -> Controller:
        """What flies it."""
        return self.plan.controller

    @property
    def mission(self) -> Mission:
        """The references of the flight."""
        return self.plan.mission

    @property
    def period(self) -> float:
        """Control period, s."""
        return self.plan.period

    @property
    def window(self) -> Window:
        """Which rows of the mission a tick reads."""
        return self.plan.window

    @property
    def times(self) -> np.ndarray:
        """Times since take-off of every tick that the flight may have, s."""
        return self.plan.times

    @property
    def count(self) -> int:
        """Ticks that the flight may have."""
        return self.plan.count

    @property
    def traceable(self) -> bool:
        """Whether sensors, controller and actuators can be compiled to one function."""
        return self.plan.traceable

    @property
    def plant(self) -> Plant:
        """The robot that really flies, and its surface."""
        experiment = self.experiment
        return self._of(build_plant, self.robot, experiment.surface, experiment.plant, self.period)

    @property
    def start(self) -> mujoco.MjData:
        """The plant's state before the first tick."""
        return self._of(initial_data, self.plant, self.mission)

    @property
    def initial_tick_state(self) -> Any:
        """Sensors, controller and mission clock before the first tick, as a record."""
        sensors = self.experiment.sensors
        return self._of(_tick_state, self._traced_controller, sensors, self.start, self.period)

    @property
    def tick(self) -> CompiledTick:
        """The compiled tick; only for a controller that can be traced."""
        controller, sensors = self._traced_controller, self.experiment.sensors
        return self._of(_tick, controller, self.plant, sensors, self.start, self.period)

    @property
    def fixed_rows(self) -> FlightRows:
        """References and noise of the whole mission, whenever the flight is stopped."""
        experiment = self.experiment
        return self._of(
            flight_rows, self.plant.robot, self.mission, experiment.sensors, experiment.seed, self.window
        )

    @property
    def rows(self) -> FlightRows:
        """References and noise of the flight."""
        return self.fixed_rows.until(self.count)

    @property
    def timeline(self) -> Timeline:
        """What the events do at every tick."""
        return self.timeline_until(self.times)

    def timeline_until(self, times: np.ndarray) -> Timeline:
        """What the events do at the ticks that begin at these times, s."""
        return self.plan.timeline(self.plan.stage._replace(plant=self.plant), times)

    @property
    def surface_table(self) -> np.ndarray | None:
        """What the surface is at every tick; None where it does not change."""
        changes = tuple(one for one in self.experiment.events if isinstance(one, SurfaceChange))
        return self._of(surface_table, changes, self.experiment.surface, self.times) if changes else None

    def changed(self, experiment: Experiment) -> Takeoff:
        """The same flight of another experiment; what its changes do not touch is shared.

        Raises:
            ConfigError: when it cannot be flown.
        """
        return simulated(self.plan.changed(experiment))

    def data(self) -> mujoco.MjData:
        """The plant's state before the first tick, as a copy of its own."""
        data = mujoco.MjData(self.plant.model)
        mujoco.mj_copyData(data, self.plant.model, self.start)
        return data

    @property
    def _of(self) -> Any:
        return self.plan.derived.of

    @property
    def _traced_controller(self) -> TraceableController:
        if not is_traceable(self.controller):
            raise ConfigError(f"controller '{self.controller.name}' cannot be compiled")
        return self.controller


def simulated(plan: FlightPlan) -> Takeoff:
    """A plan with its plant, checked against each other.

    Raises:
        ConfigError: when the time step cannot carry the surface's stiffness, now or after an event; or the
            robot would start inside of the surface, as its servos give way in hover.
    """
    takeoff = Takeoff(plan)
    stage = plan.stage._replace(plant=takeoff.plant)
    require_events(plan.experiment.events, stage, float(plan.times[-1]))
    start, model = takeoff.start, takeoff.plant.model
    bodies = [i for i in range(1, model.nbody) if not model.body(i).name.startswith("surface")]
    points = np.vstack([start.xpos[bodies], start.site(TIP_SITE).xpos])
    require_clear(plan.experiment.surface, points, plan.robot.description.tip.radius, plan.robot.name)
    return takeoff


def take_off(
    experiment: str | Experiment,
    controllers: Sequence[str | Controller | None],
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    use: Sequence[Use] = (),
    calibration: Calibrated | None = None,
) -> list[Takeoff]:
    """Simulated flights about to begin, one for each controller; see `plan_flights`."""
    return [simulated(plan) for plan in plan_flights(experiment, controllers, seed, set, use, calibration)]


def prepare(
    experiment: Experiment,
    robot: Robot,
    controller: Controller,
    originals: tuple[Bundle, ...] = (),
    own: tuple[UserScore, ...] = (),
) -> Takeoff:
    """Plan and plant of an experiment, checked; arguments are those of `plan_flight`."""
    return simulated(plan_flight(experiment, robot, controller, originals, own))


def _root(start: mujoco.MjData) -> np.ndarray:
    """Pose and twist of the root link before take-off, (13,)."""
    return np.concatenate([start.qpos[0:7], start.qvel[0:6]])


def _tick_state(controller: TraceableController, sensors: Any, start: mujoco.MjData, period: float) -> Any:
    return initial_tick_state(controller, sensors, _root(start), period)


def _tick(
    controller: TraceableController, plant: Plant, sensors: Any, start: mujoco.MjData, period: float
) -> CompiledTick:
    return compile_tick(controller, plant, sensors, _root(start), period)
