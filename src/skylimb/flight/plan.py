"""The plan of a flight: all that is known and checked before take-off, without an engine.

A simulated flight is a plan with a plant (`flight.takeoff`), the flight of a real robot a plan with a link
(`flight.realtime.fly_robot`). Every way to fly takes one, and none checks again what `checked` checks.
"""

from __future__ import annotations

import functools
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, Self, TypeVar

import numpy as np

from skylimb.analysis.scores.user_scores import UserScore
from skylimb.base.sources import Source
from skylimb.control.controller import Controller, is_traceable
from skylimb.control.missions.configuration import MOST_PATIENCE, MissionConfig
from skylimb.control.missions.frame import contact_frame
from skylimb.control.missions.mission import Mission
from skylimb.control.missions.plan import NOTHING, StandingOut, plan_mission
from skylimb.control.missions.posture import posture_plan
from skylimb.control.missions.table import Window, window_of
from skylimb.control.needs import Needs, needs_of, require_imu, require_memory
from skylimb.control.planning.posture_path import PostureConfig
from skylimb.flight.derived import Derived
from skylimb.flight.events import Event, EventContext, Timeline, require_events, timeline
from skylimb.flight.experiments.experiment import Experiment
from skylimb.flight.feasible import require_feasible
from skylimb.flight.flyable import require_flyable, standing_out
from skylimb.robots.model import Robot
from skylimb.simulation.plant_config import require_plant
from skylimb.simulation.surfaces import Surface


@dataclass(frozen=True)
class FlightPlan:
    """A flight before it has a vehicle; `checked` says whether it can be flown.

    Attributes:
        experiment: what is flown.
        robot: as it is described.
        controller: what flies it; it may believe in another robot.
        originals: TOML files that its user named, for people to read: the configuration has their values.
        own: metrics and figures of the user.
        derived: what was computed from all of that.
    """

    experiment: Experiment
    robot: Robot
    controller: Controller
    originals: tuple[Source, ...] = ()
    own: tuple[UserScore, ...] = ()
    derived: Derived = field(default_factory=Derived, repr=False, compare=False)

    @property
    def period(self) -> float:
        """Control period, s."""
        return self.experiment.control_period

    @property
    def needs(self) -> Needs:
        """What the controller needs of the loop."""
        return needs_of(self.controller)

    @property
    def traceable(self) -> bool:
        """Whether the controller can be compiled."""
        return is_traceable(self.controller)

    @property
    def mission(self) -> Mission:
        """The references of the flight."""
        needs = self.needs
        inputs = _mission_inputs(self.experiment, self.robot, needs.vectoring, needs.slowest)
        return self.derived.of(_mission, *inputs)

    @property
    def window(self) -> Window:
        """Which rows of the mission a tick reads."""
        needs = self.needs
        return self.derived.of(window_of, needs.preview, needs.paced, self.period)

    @property
    def times(self) -> np.ndarray:
        """Times since take-off of every tick that the flight may have, s."""
        return self.derived.of(Mission.flight_times, self.mission, self.window.paced)

    @property
    def count(self) -> int:
        """Ticks that the flight may have."""
        times, stop_at = self.times, self.experiment.stop_at
        return len(times) if stop_at is None else max(1, int(np.searchsorted(times, stop_at - 1e-9)))

    @property
    def event_context(self) -> EventContext:
        """What events act on, without a plant."""
        plant = self.experiment.plant
        touches = "foot" if plant.foot is not None else "peg" if plant.peg is not None else "ball"
        supervised = bool(self.experiment.supervisor.on) and self.traceable
        where = self.experiment.surface, self.period, touches, self.experiment.sensors
        return EventContext(self.robot, self.controller, *where, supervised)

    def timeline(self, times: np.ndarray) -> Timeline:
        """What the events do at the ticks that begin at these times, s; here those on the controller."""
        return self.derived.of(timeline, self.experiment.events, self.event_context, times)

    def changed(self, experiment: Experiment) -> Self:
        """The same flight of another experiment; what its changes do not touch is not computed again.

        Raises:
            ConfigError: when it cannot be flown.
        """
        other = replace(self, experiment=experiment)
        return checked(other, self.known_to(other))

    def known_to(self, other: FlightPlan) -> Sequence[Event]:
        """The events of this plan, where those of another act on the same things."""
        return self.experiment.events if self.event_context == other.event_context else ()


P = TypeVar("P", bound=FlightPlan)


def checked(plan: P, known: Sequence[Event] = ()) -> P:
    """The plan after every check that can be made before take-off, each event at the time that is drawn.

    Whether it is supervised is said in what comes back, by its controller where its experiment does not.

    Args:
        plan: to check.
        known: events that a plan like it was checked with.

    Raises:
        ConfigError: the controller cannot work at this rate, or with frames as old as these; a posture, a
            push or the commanded force cannot be held; the robot would start inside of the surface, its tip
            does not fit, or the path leaves the surface; the flight may take too long; or an event names what
            is not there.
    """
    plan = _supervised(plan)
    experiment, robot, controller = plan.experiment, plan.robot, plan.controller
    if is_traceable(controller):
        controller.require(plan.period)
    require_imu(controller, experiment.sensors.imu.on, "set sensors.imu.on = true, where the robot has one")
    require_memory(controller, experiment.sensors.latency, plan.period)
    require_plant(robot.description, experiment.surface, experiment.plant, plan.period)
    require_events(experiment.events, plan.event_context, np.inf, known)
    require_feasible(experiment, robot, controller)
    require_flyable(experiment.surface, robot, plan.mission)
    require_events(experiment.events, plan.event_context, float(plan.times[-1]), experiment.events)
    if all(event.latest is None for event in experiment.events):
        return plan
    events = tuple(event.drawn(experiment.seed, number) for number, event in enumerate(experiment.events))
    return replace(plan, experiment=replace(experiment, events=events))


def _supervised(plan: P) -> P:
    """A plan whose experiment says whether it is supervised."""
    experiment = plan.experiment
    if experiment.supervisor.on is not None:
        return plan
    supervisor = replace(experiment.supervisor, on=plan.needs.supervised)
    return replace(plan, experiment=replace(experiment, supervisor=supervisor))


def mission_of(experiment: Experiment, robot: Robot, vectoring: str = "torque") -> Mission:
    """The mission of an experiment, whoever flies it.

    Args:
        experiment: what to fly.
        robot: the description that the nominal posture is made from.
        vectoring: which vectoring angles the nominal posture has (`Needs.vectoring`).
    """
    return _mission(*_mission_inputs(experiment, robot, vectoring))


def _mission_inputs(
    experiment: Experiment, robot: Robot, vectoring: str, slowest: float = 1.0
) -> tuple[Any, ...]:
    """What a mission depends on, in the order of `_mission`."""
    config = MissionConfig(*(getattr(experiment, part.name) for part in fields(MissionConfig)))
    patience = max(config.phases.patience, min(1.0 / slowest, MOST_PATIENCE))
    config = replace(config, phases=replace(config.phases, patience=patience))
    place = experiment.contact_axis, experiment.path_center, experiment.posture
    return config, *place, experiment.surface, experiment.control_period, robot, vectoring


def _mission(
    config: MissionConfig,
    contact_axis: tuple[float, float, float],
    center: tuple[float, float, float],
    posture: PostureConfig,
    surface: Surface,
    dt: float,
    robot: Robot,
    vectoring: str,
) -> Mission:
    plan = config, contact_axis, center, posture, robot, vectoring, dt
    # A path that is read from a file may change from one flight to the next.
    shared = config.trajectory.shape not in ("drawing", "own") and _is_hashable(plan)
    planned = _planned if shared else _planned.__wrapped__
    mission = planned(*plan)
    stands_out = standing_out(surface, mission)
    return planned(*plan, stands_out) if stands_out.ways else mission


@functools.lru_cache(maxsize=8)
def _planned(
    config: MissionConfig,
    contact_axis: tuple[float, float, float],
    center: tuple[float, float, float],
    posture: PostureConfig,
    robot: Robot,
    vectoring: str,
    dt: float,
    stands_out: StandingOut = NOTHING,
) -> Mission:
    """The mission of a configuration; flights that differ in noise, plant or surface share one."""
    return plan_mission(
        config,
        contact_frame(contact_axis),
        np.asarray(center, dtype=float),
        posture_plan(posture, robot, vectoring),
        dt,
        stands_out,
    )


def _is_hashable(value: Hashable) -> bool:
    try:
        hash(value)
    except TypeError:  # a configuration made in Python may hold lists
        return False
    return True
