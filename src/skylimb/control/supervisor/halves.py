"""The supervisor for a controller that flies in Python: its halves as machine-ready functions on arrays."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from math import inf
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from skylimb.base.bound_function import BoundFunction
from skylimb.base.packing import Layout, flattened
from skylimb.control.estimation.records import Measurement, zero_measurement
from skylimb.control.missions.reference import Reference, zero_reference
from skylimb.control.records import Command
from skylimb.control.supervisor.descents import NO_DESCENTS, descents_of
from skylimb.control.supervisor.limits import Limits
from skylimb.control.supervisor.records import Flags, initial_watch
from skylimb.control.supervisor.supervisor import after, before
from skylimb.control.thrust_and_angle import from_pairs
from skylimb.robots.model import Robot


class Compiled(NamedTuple):
    """Both halves as functions of flat vectors; they remember nothing, and flights share them.

    Attributes:
        look: of watch, measurement and reference: watch and sight.
        act: of watch, sight, command and whether that is sound: watch, command and whether it is
            the controller's.
        watch: what is remembered.
        measurement: what is measured.
        reference: with those ahead of it.
        sight: what the controller is given.
        command: of the vehicle.
        first: watch before the first tick.
    """

    look: ca.Function
    act: ca.Function
    watch: Layout[Any]
    measurement: Layout[Any]
    reference: Layout[Any]
    sight: Layout[Any]
    command: Layout[Any]
    first: np.ndarray


@functools.lru_cache(maxsize=8)
def compiled(robot: Robot, limits: Limits, ahead: int, dt: float, imu: bool, purpose: str | None) -> Compiled:
    """Both halves; see `Halves`."""
    zero, first = zero_reference(robot.n_joints, robot.n_vectoring), initial_watch(robot, imu)
    descents = NO_DESCENTS if purpose is None else descents_of(robot, purpose, limits)
    watch, command = Layout(first), Layout(from_pairs(robot, first.command))
    measurement = Layout(zero_measurement(robot.n_joints, robot.n_vectoring, imu))
    reference = Layout(zero._replace(ahead=(zero,) * ahead))
    sight: Layout[Any] = Layout(())

    def looked(was: Any, measured: Any, wanted: Any) -> tuple[Any, ...]:
        nonlocal sight
        given = watch.unpack(was), measurement.unpack(measured), reference.unpack(wanted)
        new, seen = before(robot, limits, descents, *given, dt)
        sight = Layout(seen)
        return watch.pack(new), sight.pack(seen)

    def acted(was: Any, seen: Any, wanted: Any, sound: Any) -> tuple[Any, ...]:
        given = watch.unpack(was), sight.unpack(seen), command.unpack(wanted), sound
        new, made, own = after(robot, limits, descents, *given, dt)
        return watch.pack(new), command.pack(made), own

    look = _function(looked, (watch.size, measurement.size, reference.size))
    act = _function(acted, (watch.size, sight.size, command.size, 1))
    layouts = watch, measurement, reference, sight, command
    return Compiled(look, act, *layouts, np.asarray(watch.pack(first), dtype=float))


class Halves:
    """Both halves of the supervisor, compiled, and what is remembered between them.

    Args:
        robot: the model.
        limits: when the supervisor acts.
        ahead: how many references ahead of its own a reference holds.
        dt: control period, s.
        imu: whether the controller works on an IMU.
        purpose: of the vectoring angles: with it the loss of a rotor is answered where it can be.

    Raises:
        ConfigError: the control period is too short for the latency that is assumed.

    Attributes:
        sight: what the last look came to.
        mode: number of the mode.
        started: whether a pose was believed yet.
        late: how much later than assumed measurements are, s.
        slow: by how much more than assumed the rotors lag, s.
        back: since the pose was the model's, s.
    """

    def __init__(
        self,
        robot: Robot,
        limits: Limits,
        ahead: int,
        dt: float,
        imu: bool,
        purpose: str | None = None,
    ) -> None:
        limits.require(dt)
        self._made = made = compiled(robot, limits, ahead, dt, imu, purpose)
        self._state = made.first.copy()
        self._measured, self._wanted = np.zeros(made.measurement.size), np.zeros(made.reference.size)
        self._looked, self._seen = np.zeros(made.watch.size), np.zeros(made.sight.size)
        self._asked, self._sound = np.zeros(made.command.size), np.zeros(1)
        self._command, self._own = np.zeros(made.command.size), np.zeros(1)
        given = [self._state, self._measured, self._wanted]
        self._look = BoundFunction(made.look, given, [self._looked, self._seen])
        given = [self._looked, self._seen, self._asked, self._sound]
        self._act = BoundFunction(made.act, given, [self._state, self._command, self._own])
        self.sight: Any = None
        self.mode, self.started, self.late, self.slow, self.back = 0.0, False, 0.0, 0.0, inf

    def begin(self) -> None:
        """Forget all that was seen."""
        self._state[:] = self._made.first

    def look(self, flags: Flags, measurement: Measurement | None, reference: Reference) -> Any:
        """What the controller is given; see `before`."""
        for name, value in zip(Flags._fields, flags, strict=True):
            self._state[self._made.watch.slices[f"flags.{name}"]] = value
        if measurement is not None:
            self._measured[:] = flattened(measurement.entries)
        self._wanted[:] = flattened(reference.entries)  # a number may stand for a vector of one
        self._look.evaluate()
        self.sight = self._made.sight.unpack(self._seen.copy())
        self.mode = self._looked[self._made.watch.slices["mode"]][0]
        self.started = self._looked[self._made.watch.slices["started"]][0] > 0.5
        self.late = float(self._looked[self._made.watch.slices["late.late"]][0])
        self.slow = float(self._looked[self._made.watch.slices["late.slow"]][0])
        self.back = float(self._looked[self._made.watch.slices["clocks.back"]][0])
        return self.sight

    def act(self, wanted: Command | None) -> tuple[Command, bool]:
        """The command, and whether it is the controller's; see `after`."""
        self._sound[:] = float(wanted is not None)
        if wanted is not None:
            self._asked[:] = flattened(wanted)
        self._act.evaluate()
        return self._made.command.unpack(self._command.copy()), bool(self._own[0] > 0.5)


def _function(made: Callable[..., tuple[Any, ...]], sizes: Sequence[int]) -> ca.Function:
    """A function of flat vectors."""
    symbols = [ca.SX.sym(f"given_{index}", size) for index, size in enumerate(sizes)]
    results = [ca.densify(part) for part in made(*symbols)]
    return ca.Function(made.__name__, symbols, results, {"cse": True})
