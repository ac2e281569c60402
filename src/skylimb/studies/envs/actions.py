"""What a policy may do. An action is a list of numbers between -1 and 1, held for a step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from skylimb.base.errors import ConfigError, unknown_name
from skylimb.base.packing import Layout
from skylimb.control.controller import Controller, TraceableController
from skylimb.control.estimation.records import Measurement
from skylimb.control.laws.user_controller import user_controller
from skylimb.control.missions.reference import Reference
from skylimb.control.planning.vectoring import nominal_posture
from skylimb.control.records import Command
from skylimb.control.thrust_and_angle import from_pairs
from skylimb.flight.drivers.native.lockstep import LockStep
from skylimb.flight.takeoff import Takeoff
from skylimb.robots.model import Robot
from skylimb.simulation.rows import reference_layout
from skylimb.studies.envs.tasks import EnvSettings


class Actions(Protocol):
    """A way to act on flights in lock-step.

    Attributes:
        names: of the entries of an action.
        neutral: the action that leaves a flight as it is.
    """

    names: tuple[str, ...]
    neutral: np.ndarray

    def begin(self, flights: LockStep, place: int) -> None:
        """A place has begun another flight."""
        ...

    def act(self, flights: LockStep, place: int, action: np.ndarray, ticks: int) -> None:
        """Let an action count in a place for the ticks that come next."""
        ...


class References:
    """Moves the path in the task's own axes: n into the surface, u and v along it."""

    def __init__(self, takeoff: Takeoff, reach: float) -> None:
        self.names, self.neutral = ("path_n", "path_u", "path_v"), np.zeros(3)
        layout = reference_layout(takeoff.plant.robot)
        self._moved = [layout.slices[name] for name in ("position", "tip_position")]
        frame = takeoff.mission.frame
        self._axes = reach * np.array([frame.contact, frame.sliding_u, frame.sliding_v])
        self._beyond = takeoff.window.rows
        self._own: dict[int, np.ndarray] = {}

    def begin(self, flights: LockStep, place: int) -> None:
        """A copy of the references that may be written."""
        self._own[place] = flights.own_references(place)

    def act(self, flights: LockStep, place: int, action: np.ndarray, ticks: int) -> None:
        """Write the rows that the next ticks read, with the path moved."""
        at = int(flights.flights[place].record.at)
        # A pace may be above 1.
        rows = slice(at, at + 2 * ticks + self._beyond)
        given = flights.asked[place][rows]
        for columns in self._moved:
            self._own[place][rows, columns] = given[:, columns] + action @ self._axes


class Numbers:
    """Writes numbers of the controller: its gains, each from one end of its range to the other.

    Args:
        columns: of each entry of an action in the flat gains.
        low: its value at -1.
        high: its value at 1.
        names: of the entries.
        neutral: values that leave a flight as it is.
    """

    def __init__(
        self,
        columns: np.ndarray,
        low: np.ndarray,
        high: np.ndarray,
        names: tuple[str, ...],
        neutral: np.ndarray,
    ) -> None:
        self.names, self._columns = names, columns
        self._middle, self._half = 0.5 * (low + high), 0.5 * (high - low)
        self.neutral = np.clip(
            (neutral - self._middle) / np.where(self._half > 0.0, self._half, 1.0), -1.0, 1.0
        )

    def begin(self, flights: LockStep, place: int) -> None:
        """Nothing is remembered."""

    def act(self, flights: LockStep, place: int, action: np.ndarray, ticks: int) -> None:
        """Write the values."""
        flights.gains[place][self._columns] = self._middle + self._half * action


def gains(controller: TraceableController, ranges: dict[str, tuple[float, float]], dt: float) -> Numbers:
    """Acts on gains of a controller.

    Args:
        controller: that has them.
        ranges: dotted gain -> its value at -1 and at 1, of every entry where it has several.
        dt: control period, s.

    Raises:
        ConfigError: for a gain that is none, may not have such values, or that a law prepares something of.
    """
    layout = Layout(controller.gains())
    known = [key for key in layout.slices if not key.startswith("prepared.")]
    prepared = {key.split(".")[1] for key in layout.slices if key.startswith("prepared.")}
    flat, columns, ends, names = layout.pack(controller.gains()), [], [], []
    for key, (low, high) in ranges.items():
        if key not in known:
            raise unknown_name(f"gain of controller {controller.name}", key, known)
        if key.partition(".")[0] in prepared:
            raise ConfigError(
                f"gain '{key}': its law prepares something of its gains, so no action can set it"
            )
        where = np.r_[layout.slices[key]]
        for value in (low, high):
            given = value if layout.shapes[key] == () else [value] * len(where)
            controller.check_gain(key, given, f"gains of an environment, controller {controller.name}", dt)
        columns += list(where)
        ends += [(low, high)] * len(where)
        names += [key] if len(where) == 1 else [f"{key}.{i}" for i in range(len(where))]
    low, high = np.array(ends).T
    return Numbers(np.array(columns), low, high, tuple(names), flat[columns])


@dataclass(frozen=True)
class Commanded:
    """What is commanded: the only gains of a controller that does nothing else.

    Attributes:
        thrusts: N.
        bend: added to the mission's joint angles, rad.
    """

    thrusts: tuple[float, ...]
    bend: tuple[float, ...]


class Direct:
    """Passes on what is commanded; the vectoring angles are the mission's, or those of pairs."""

    name = "direct"

    def __init__(self, robot: Robot) -> None:
        self._robot, pairs = robot, robot.pairs
        hover = pairs.at(*nominal_posture(pairs, "torque"))
        self._given = Commanded(tuple(map(float, hover.hover_thrusts)), (0.0,) * robot.n_joints)

    def gains(self) -> Commanded:
        """Hover in the nominal posture."""
        return self._given

    def initial_state(self) -> tuple[()]:
        """Nothing is remembered."""
        return ()

    def step(
        self, gains: Any, state: Any, measurement: Measurement, reference: Reference, dt: float
    ) -> tuple[Any, Command, dict[str, Any]]:
        """The command that the gains are."""
        # No symbol is added to nothing: a robot without an arm has no joints.
        joints = reference.joint_angles + gains.bend if self._robot.n_joints else reference.joint_angles
        command = Command(gains.thrusts, joints, reference.vectoring_angles)
        return state, from_pairs(self._robot, command), {}


def commands(takeoff: Takeoff, bend: float) -> Numbers:
    """Acts on thrusts, from least to greatest, and on joints, about the mission's posture.

    Thrusts are those of pairs where the robot is flown so (`robots.turned_rotors`).
    """
    layout = Layout(takeoff.controller.gains())
    rotors, joints = takeoff.robot.pairs.description.rotors, takeoff.robot.n_joints
    low = np.array([*(rotor.thrust_min for rotor in rotors), *[-bend] * joints])
    high = np.array([*(rotor.thrust_max for rotor in rotors), *[bend] * joints])
    names = *(f"thrust_{rotor.name}" for rotor in rotors), *(f"bend_{i}" for i in range(joints))
    columns = np.r_[layout.slices["thrusts"], layout.slices.get("bend", slice(0, 0))]
    return Numbers(columns, low, high, names, layout.pack(takeoff.controller.gains())[columns])


def actions_of(settings: EnvSettings, takeoff: Takeoff) -> Actions:
    """The way to act that an environment has."""
    if settings.actions == "references":
        return References(takeoff, settings.reach)
    if settings.actions == "commands":
        return commands(takeoff, settings.bend)
    controller: Any = takeoff.controller
    return gains(controller, settings.gains, takeoff.period)


def controller_of(settings: EnvSettings, robot: Robot, given: Controller) -> Controller:
    """What flies: the campaign's controller, or one that passes commands on."""
    return user_controller(Direct(robot), robot) if settings.actions == "commands" else given
