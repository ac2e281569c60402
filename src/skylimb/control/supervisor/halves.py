"""The supervisor for a controller that flies in Python: its halves as machine-ready functions on arrays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import numpy as np

from skylimb.base.bound_function import BoundFunction
from skylimb.base.packing import Layout
from skylimb.control.estimation.records import Measurement
from skylimb.control.missions.reference import Reference, zero_reference
from skylimb.control.records import Command
from skylimb.control.supervisor.descents import NO_DESCENTS, Descents
from skylimb.control.supervisor.limits import Limits
from skylimb.control.supervisor.records import Told, initial_watch
from skylimb.control.supervisor.supervisor import after, before
from skylimb.robots.model import Robot


class Halves:
    """Both halves of the supervisor, compiled, and what is remembered between them.

    Args:
        robot: the model.
        limits: when the supervisor acts.
        ahead: how many references ahead of its own a reference holds.
        dt: control period, s.
        imu: whether the controller works on an IMU.
        descents: for the loss of each rotor.

    Attributes:
        sight: what the last look came to.
        mode: number of the mode.
        started: whether a pose was believed yet.
        late: how much later than assumed measurements are, s.
    """

    def __init__(
        self,
        robot: Robot,
        limits: Limits,
        ahead: int,
        dt: float,
        imu: bool,
        descents: Descents = NO_DESCENTS,
    ) -> None:
        zero, first = zero_reference(robot.n_joints, robot.n_vectoring), initial_watch(robot, imu)
        self._watch, self._commands = Layout(first), Layout(first.command)
        self._measurement = Layout(first.before)
        self._reference = Layout(zero._replace(ahead=(zero,) * ahead))

        self._sight: Layout[Any] = Layout(())

        def look(watch: Any, measured: Any, reference: Any) -> tuple[Any, ...]:
            given = self._measurement.unpack(measured), self._reference.unpack(reference)
            looked, sight = before(robot, limits, descents, self._watch.unpack(watch), *given, dt)
            self._sight = Layout(sight)
            return self._watch.pack(looked), self._sight.pack(sight)

        def act(watch: Any, sight: Any, wanted: Any, sound: Any) -> tuple[Any, ...]:
            given = self._watch.unpack(watch), self._sight.unpack(sight), self._commands.unpack(wanted), sound
            acted, command, made = after(robot, limits, descents, *given, dt)
            return self._watch.pack(acted), self._commands.pack(command), made

        sizes = self._watch.size, self._measurement.size, self._reference.size
        self._look, (self._state, *self._given), (self._looked, self._seen) = _bound(look, sizes)
        sizes = self._watch.size, self._sight.size, self._commands.size, 1
        self._act, handed, (_, self._command, self._made) = _bound(act, sizes)
        _, _, self._wanted, self._sound = handed
        self._act.bind([self._looked, self._seen, *handed[2:]], [self._state, self._command, self._made])
        self._state[:] = self._watch.pack(first)
        self.sight: Any = None
        self.mode, self.started, self.late = 0.0, False, 0.0

    def look(self, told: Told, measurement: Measurement | None, reference: Reference) -> Any:
        """What the controller is given; see `before`."""
        for name, value in zip(Told._fields, told, strict=True):
            self._state[self._watch.slices[f"told.{name}"]] = value
        if measurement is not None:
            self._given[0][:] = self._measurement.pack(measurement)
        self._given[1][:] = self._reference.pack(reference)
        self._look.evaluate()
        self.sight = self._sight.unpack(self._seen.copy())
        self.mode = self._looked[self._watch.slices["mode"]][0]
        self.started = self._looked[self._watch.slices["started"]][0] > 0.5
        self.late = float(self._looked[self._watch.slices["late.late"]][0])
        return self.sight

    def act(self, wanted: Command | None) -> tuple[Command, bool]:
        """The command, and whether it is the controller's; see `after`."""
        self._sound[:] = float(wanted is not None)
        if wanted is not None:
            self._wanted[:] = self._commands.pack(wanted)
        self._act.evaluate()
        return self._commands.unpack(self._command.copy()), bool(self._made[0] > 0.5)


def _bound(
    made: Callable[..., tuple[Any, ...]], sizes: Sequence[int]
) -> tuple[BoundFunction, list[np.ndarray], list[np.ndarray]]:
    """A function of flat vectors on arrays, and its arguments and results."""
    symbols = [ca.SX.sym(f"given_{index}", size) for index, size in enumerate(sizes)]
    function = ca.Function(
        made.__name__, symbols, [ca.densify(part) for part in made(*symbols)], {"cse": True}
    )
    given = [np.zeros(size) for size in sizes]
    results = [np.zeros(function.numel_out(index)) for index in range(function.n_out())]
    return BoundFunction(function, given, results), given, results
