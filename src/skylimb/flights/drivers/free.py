"""The driver for any Python controller on any vehicle: slower than the compiled tick, else its equal."""

from __future__ import annotations

from typing import Any

import numpy as np

from skylimb.control.controller import Controller
from skylimb.control.needs import PACE, needs_of
from skylimb.control.records import Command
from skylimb.errors import ConfigError
from skylimb.loop.flight import MISSION_TIME
from skylimb.loop.vehicle import Vehicle
from skylimb.missions.clock import next_clock, start_of_mission
from skylimb.missions.mission import Mission
from skylimb.missions.table import window_of
from skylimb.packing import Layout
from skylimb.robots.model import Robot
from skylimb.symbolic import is_symbolic
from skylimb.user_code import told_error


class FreeDriver:
    """Measure, control, record, apply: one tick of any controller on any vehicle.

    Args:
        controller: any object that follows `Controller`.
        vehicle: what it flies.
        robot: gives the sizes that a command must have.
        mission: the references of the flight.
        count: ticks that the flight may have.
    """

    def __init__(
        self, controller: Controller, vehicle: Vehicle, robot: Robot, mission: Mission, count: int
    ) -> None:
        self._controller, self._vehicle, self._robot, self._mission = controller, vehicle, robot, mission
        needs = needs_of(controller)
        self._window = window_of(needs.preview, needs.paced, mission.period)
        self._clock, self._count = start_of_mission(), count
        self._gains, self._state = controller.gains(), controller.initial_state()
        self._own: Layout[dict[str, Any]] = Layout({})
        self._layout, self._log = vehicle.layout, np.zeros((0, vehicle.layout.size))

    @property
    def layout(self) -> Layout[dict[str, Any]]:
        """Signals of the vehicle, then those of the controller; complete after the first tick."""
        return self._layout

    @property
    def log(self) -> np.ndarray:
        """One row of signals a tick."""
        return self._log

    def fault(self) -> str:
        """The vehicle's own fault."""
        return self._vehicle.fault()

    def tick(self, k: int) -> int:
        """Fly one tick.

        Raises:
            ConfigError: when the controller fails, or its command or signals do not fit.
        """
        vehicle, controller, dt = self._vehicle, self._controller, self._mission.period
        measurement = vehicle.measure()
        reference = self._mission.at(self._clock, self._window.preview)
        try:
            self._state, command, signals = controller.step(
                self._gains, self._state, measurement, reference, dt
            )
        except Exception as error:
            raise told_error(f"controller '{controller.name}' at t = {k * dt:.3f} s", error) from error
        command = _checked(controller.name, command, self._robot)
        own = {name: _number(value) for name, value in signals.items()}
        pace = 1.0
        if self._window.paced:
            if PACE not in own:
                raise ConfigError(
                    f"controller '{controller.name}' sets the mission's pace, but has no signal 'pace'"
                )
            pace, own[MISSION_TIME] = own[PACE], self._clock.ticks * dt
        if k == 0:
            self._begin_log(own)
        width = self._vehicle.layout.size
        self._log[k, :width] = vehicle.record(measurement, command)
        self._log[k, width:] = self._own.pack(own)
        vehicle.apply(command)
        self._clock = next_clock(self._clock, pace)
        return int(self._clock.ticks)

    def _begin_log(self, own: dict[str, Any]) -> None:
        # Only now is it known which signals this controller records.
        self._own = Layout(own)
        self._layout = Layout(_zeros(self._vehicle.layout) | _zeros(self._own))
        self._log = np.full((self._count, self._layout.size), np.nan)


def _number(value: Any) -> Any:
    """A float or an array, also from CasADi's numbers, whose vectors are columns."""
    array = np.asarray(value, dtype=float)
    array = array.squeeze() if is_symbolic(value) else array
    return float(array) if array.ndim == 0 else array


def _zeros(layout: Layout[Any]) -> dict[str, Any]:
    return {name: np.zeros(shape) if shape else 0.0 for name, shape in layout.shapes.items()}


def _checked(name: str, command: Any, robot: Robot) -> Command:
    sizes = {
        "thrusts": robot.n_rotors,
        "joint_angles": robot.n_joints,
        "vectoring_angles": robot.n_vectoring,
    }
    values = []
    for field, length in sizes.items():
        value = np.asarray(getattr(command, field, np.zeros(0)), dtype=float).ravel()
        if len(value) != length:
            raise ConfigError(f"controller '{name}' gave {len(value)} {field}; {robot.name} takes {length}")
        values.append(value)
    return Command(*values)
