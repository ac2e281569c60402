"""A simulated flight about to begin: its plan with a plant, and everything that a driver needs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Self

import mujoco
import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.control.controller import Controller, TraceableController, is_traceable
from skylimb.control.corrections import Calibrated
from skylimb.control.supervisor.supervised import Supervised
from skylimb.flight.events import (
    OWN_PLANT_KINDS,
    Event,
    SensorFault,
    SurfaceChange,
    Timeline,
    require_applied,
    require_events,
    timeline,
)
from skylimb.flight.events.rotor import thrust_scales
from skylimb.flight.events.surface import surface_table
from skylimb.flight.experiments.experiment import Experiment
from skylimb.flight.loading import Use, plan_flights
from skylimb.flight.plan import FlightPlan, checked
from skylimb.robots.model import Robot
from skylimb.simulation.plant import Plant, build_plant, initial_data
from skylimb.simulation.plant_tick import at_rest, rotor_scales
from skylimb.simulation.robot_bodies import TIP_SITE
from skylimb.simulation.rows import FlightRows, flight_rows
from skylimb.simulation.sensors import SensorConfig
from skylimb.simulation.surfaces import require_clear
from skylimb.simulation.tick import CompiledTick, compile_tick, initial_tick_state
from skylimb.simulation.user_plant import UserPlant, plant_name, require_own


@dataclass(frozen=True)
class Takeoff(FlightPlan):
    """A flight plan with a simulated plant. Nothing writes into it or into what it holds.

    Attributes:
        own_plant: a user's simulator that flies in the engine's place.
    """

    own_plant: UserPlant | None = None

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
        sensors, rest = self.remembering, self._of(at_rest, self.plant, self.start)
        return self._of(initial_tick_state, self._traced_controller, self.plant, sensors, rest, self.period)

    @property
    def tick(self) -> CompiledTick:
        """The compiled tick; only for a controller that can be traced."""
        sensors, rest = self.remembering, self._of(at_rest, self.plant, self.start)
        return self._of(compile_tick, self._traced_controller, self.plant, sensors, rest, self.period)

    @property
    def compiled(self) -> bool:
        """Whether the whole tick is compiled: no law in its middle and no plant is in Python."""
        return self.own_plant is None and self.traceable and not self.tick.calls

    @property
    def remembering(self) -> SensorConfig:
        """The sensors with the greatest latency that they have in flight, for which they must remember."""
        sensors, events = self.experiment.sensors, self.experiment.events
        older = max((one.older(sensors) for one in events if isinstance(one, SensorFault)), default=0.0)
        return replace(sensors, latency=sensors.latency + older) if older else sensors

    @property
    def calm_rows(self) -> FlightRows:
        """References and noise of the whole mission, without what events do to the sensors."""
        experiment, events, robot = self.experiment, self.timeline(self.times), self.plant.robot
        before = self._of(rotor_scales, self.plant.model, robot.n_rotors)
        scales = self._of(thrust_scales, before, events.model)
        known = self.mission, experiment.sensors, experiment.seed, self.window
        return self._of(flight_rows, robot, *known, scales)

    @property
    def fixed_rows(self) -> FlightRows:
        """References, noise and events of the whole mission, whenever the flight is stopped."""
        rows, events = self.calm_rows, self.timeline(self.times).rows
        return rows if events is None else self._of(FlightRows.with_added, rows, events.added)

    @property
    def rows(self) -> FlightRows:
        """References and noise of the flight."""
        return self.fixed_rows.until(self.count)

    def timeline(self, times: np.ndarray) -> Timeline:
        """What the events do at the ticks that begin at these times, s, to controller and plant."""
        context = self.event_context._replace(plant=self.plant)
        return self.derived.of(timeline, self.experiment.events, context, times)

    @property
    def surface_table(self) -> np.ndarray | None:
        """What the surface is at every tick; None where it does not change."""
        changes = tuple(one for one in self.experiment.events if isinstance(one, SurfaceChange))
        return self._of(surface_table, changes, self.experiment.surface, self.times) if changes else None

    def changed(self, experiment: Experiment) -> Self:
        """The same flight of another experiment; what its changes do not touch is shared.

        Raises:
            ConfigError: when it cannot be flown.
        """
        other = super().changed(experiment)
        _require_takeoff(other, self.known_to(other))
        return other

    def data(self) -> mujoco.MjData:
        """The plant's state before the first tick, as a copy of its own."""
        data = mujoco.MjData(self.plant.model)
        mujoco.mj_copyData(data, self.plant.model, self.start)
        return data

    @property
    def _of(self) -> Any:
        return self.derived.of

    @property
    def _traced_controller(self) -> TraceableController:
        if not is_traceable(self.controller):
            raise ConfigError(f"controller '{self.controller.name}' cannot be compiled")
        limits = self.experiment.supervisor
        return self._of(Supervised, self.controller, limits) if limits.on else self.controller


def simulated(plan: FlightPlan, own_plant: UserPlant | None = None) -> Takeoff:
    """A plan with its plant, checked against each other.

    Args:
        plan: what is flown.
        own_plant: a user's simulator in the engine's place.

    Raises:
        ConfigError: when the time step cannot carry the surface's stiffness, now or after an event; or the
            robot would start inside of the surface, as its servos give way in hover; or a user's plant lacks
            what the experiment asks for.
    """
    takeoff = Takeoff(*(getattr(plan, field.name) for field in fields(FlightPlan)), own_plant=own_plant)
    _require_takeoff(takeoff)
    return takeoff


def _require_takeoff(takeoff: Takeoff, known: Sequence[Event] = ()) -> None:
    experiment = takeoff.experiment
    context = takeoff.event_context._replace(plant=takeoff.plant)
    require_events(experiment.events, context, float(takeoff.times[-1]), known)
    takeoff.timeline(takeoff.times)  # which refuses what only all events together make impossible
    if takeoff.own_plant is not None:
        require_own(takeoff.plant, takeoff.own_plant)
        require_applied(experiment.events, OWN_PLANT_KINDS, f"plant '{plant_name(takeoff.own_plant)}'")
    tip, axis = takeoff.robot.description.tip, takeoff.mission.frame.contact
    require_clear(experiment.surface, start_points(takeoff), tip.radius, takeoff.robot.name, axis)


def start_points(takeoff: Takeoff) -> np.ndarray:
    """Origins of all bodies and the tip as the robot stands before take-off, W, m, (k, 3)."""
    model, start = takeoff.plant.model, takeoff.start
    bodies = [i for i in range(1, model.nbody) if not model.body(i).name.startswith("surface")]
    return np.vstack([start.xpos[bodies], start.site(TIP_SITE).xpos])


def take_off(
    experiment: str | Path | Experiment,
    controllers: Sequence[str | Path | Controller | None],
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    use: Sequence[Use] = (),
    calibration: Calibrated | None = None,
    plant: UserPlant | None = None,
) -> list[Takeoff]:
    """Simulated flights about to begin, one for each controller; see `plan_flights` and `simulated`."""
    return [
        simulated(plan, plant) for plan in plan_flights(experiment, controllers, seed, set, use, calibration)
    ]


def prepare(experiment: Experiment, robot: Robot, controller: Controller) -> Takeoff:
    """Plan and plant of an experiment, checked."""
    return simulated(checked(FlightPlan(experiment, robot, controller)))
