"""The driver for any Python controller on any vehicle: slower than the compiled tick, else its equal."""

from __future__ import annotations

from collections.abc import Mapping, Set
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from skylimb.base.errors import UserCodeError
from skylimb.base.packing import Layout, number
from skylimb.base.user_code import described_user_error
from skylimb.control.controller import Controller
from skylimb.control.estimation.records import Measurement
from skylimb.control.loop.flight import MISSION_TIME
from skylimb.control.loop.vehicle import Vehicle
from skylimb.control.missions.clock import Clock, entries, next_clock, start_of_mission
from skylimb.control.missions.mission import Mission
from skylimb.control.missions.reference import Reference
from skylimb.control.missions.table import window_of
from skylimb.control.needs import PACE, needs_of
from skylimb.control.records import Command
from skylimb.flight.drivers.python_time import PythonTime, python_time
from skylimb.robots.model import Robot

if TYPE_CHECKING:
    from skylimb.flight.events import GainRows


class FreeDriver:
    """Measure, control, record, apply: one tick of any controller on any vehicle.

    Args:
        controller: any object that follows `Controller`.
        vehicle: what it flies.
        robot: gives the sizes that a command must have.
        mission: the references of the flight.
        count: ticks that the flight may have.
        gains: those that change in flight, where the controller's are one flat array.

    Attributes:
        layout: signals of the vehicle, then those of the controller; complete after the first tick.
        log: one row of signals a tick.
    """

    def __init__(
        self,
        controller: Controller,
        vehicle: Vehicle,
        robot: Robot,
        mission: Mission,
        count: int,
        gains: GainRows | None = None,
    ) -> None:
        self._vehicle, self._robot, self._mission = vehicle, robot, mission
        needs = needs_of(controller)
        self._window = window_of(needs.preview, needs.paced, mission.period)
        self._entries = entries(mission.reference)
        self._clock, self._count = start_of_mission(), count
        self._step, self._what = controller.step, f"controller '{controller.name}'"
        self._gains, self._state, self._changing = controller.gains(), controller.initial_state(), gains
        self._sizes = tuple(
            zip(Command._fields, (robot.n_rotors, robot.n_joints, robot.n_vectoring), strict=True)
        )
        self._own: list[tuple[str, int, int, tuple[int, ...]]] = []
        self._names: Set[str] = frozenset()
        self.layout, self._width = vehicle.layout, vehicle.layout.size
        self.log = np.zeros((0, self._width))
        self._took = np.full(count, np.nan)

    def fault(self) -> str:
        """The vehicle's own fault."""
        return self._vehicle.fault()

    @property
    def python_time(self) -> PythonTime | None:
        """How long the controller's own step takes in a tick."""
        return python_time(self._took[np.isfinite(self._took)], self._mission.period)

    def notes(self) -> tuple[str, ...]:
        """Whether the controller is too slow for its control period."""
        time = self.python_time
        return time.notes(self._what) if time else ()

    @property
    def first(self) -> Reference:
        """The reference of its first tick."""
        return self._reference(0)

    def tick(self, k: int) -> int:
        """Fly one tick.

        Raises:
            UserCodeError: when the controller fails, or its command or signals do not fit.
        """
        vehicle, dt = self._vehicle, self._mission.period
        measurement = vehicle.measure()
        reference = self._reference(k)
        if self._changing is not None:
            self._gains[self._changing.columns] = self._changing.values[k]
        begun = perf_counter()
        try:
            self._state, command, own = self._step(self._gains, self._state, measurement, reference, dt)
        except (Exception, SystemExit) as error:
            raise described_user_error(self._what, error) from error
        self._took[k] = perf_counter() - begun
        command = self._checked(command)
        pace = 1.0
        if self._window.paced:
            if PACE not in own:
                raise UserCodeError(f"{self._what} sets the mission's pace, but has no signal 'pace'")
            pace, own = float(own[PACE]), {**own, MISSION_TIME: self._clock.ticks * dt}
        if not len(self.log):
            self.prepare(own)
        row = self.log[k]
        row[: self._width] = vehicle.record(measurement, command)
        self._record(row, own)
        vehicle.apply(command)
        self._clock = next_clock(self._clock, pace) if self._window.paced else Clock(k + 1.0, 1.0)
        return int(self._clock.ticks)

    def fly_on(self, k: int) -> tuple[Measurement, Command]:
        """Fly one tick of which nothing is recorded, whatever has become of the log.

        Args:
            k: the tick; its mission may be over.
        """
        measurement = self._vehicle.measure()
        reference = self._reference(min(k, self._count - 1))
        self._state, command, _ = self._step(
            self._gains, self._state, measurement, reference, self._mission.period
        )
        self._vehicle.apply(command)
        return measurement, command

    def _reference(self, k: int) -> Reference:
        """The reference of this tick."""
        if self._window.paced or self._window.preview:
            return self._mission.at(self._clock, self._window.preview)
        return Reference(*[entry[k] for entry in self._entries])

    def prepare(self, own: Mapping[str, Any]) -> None:
        """Make room for the log, with the controller's signals of any tick; else the first one does."""
        paced = {MISSION_TIME: 0.0} if self._window.paced else {}
        layout = Layout({name: number(value) for name, value in {**own, **paced}.items()})
        self.layout = Layout(_zeros(self._vehicle.layout) | _zeros(layout))
        self._own = [
            (name, part.start + self._width, part.stop + self._width, layout.shapes[name])
            for name, part in layout.slices.items()
        ]
        self._names = layout.shapes.keys()
        self.log = np.full((self._count, self.layout.size), np.nan)

    def _record(self, row: np.ndarray, own: Mapping[str, Any]) -> None:
        """Write the controller's own signals, which have to be those of the first tick."""
        if own.keys() != self._names:
            odd = sorted(own.keys() ^ self._names)
            raise UserCodeError(
                f"{self._what} records other signals than at its first tick: {', '.join(odd)}"
            )
        for name, start, stop, shape in self._own:
            value = own[name]
            if type(value) is not float:
                value = number(value, shape)
                if np.shape(value) != shape:
                    raise UserCodeError(
                        f"{self._what} gives signal '{name}' the shape {np.shape(value)}, at its first tick "
                        f"it had {shape}"
                    )
                if len(shape) > 1:
                    value = np.ravel(value)
            row[start:stop] = value

    def _checked(self, command: Any) -> Command:
        """The command as arrays of the right sizes."""
        parts = []
        for field, length in self._sizes:
            value = np.asarray(getattr(command, field, ()), dtype=float).reshape(-1)
            if len(value) != length:
                raise UserCodeError(
                    f"{self._what} gave {len(value)} {field}; {self._robot.name} takes {length}"
                )
            parts.append(value)
        return Command(*parts)


def _zeros(layout: Layout[Any]) -> dict[str, Any]:
    return {name: np.zeros(shape) if shape else 0.0 for name, shape in layout.shapes.items()}
