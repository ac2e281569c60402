"""A controller whose step is one compiled function: the same numbers, much faster than in Python."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import casadi as ca
import numpy as np

from skylimb.base.packing import Layout
from skylimb.control.controller import TraceableController
from skylimb.control.estimation.records import Measurement
from skylimb.control.missions.reference import Reference, zero_reference
from skylimb.control.records import Command


class CompiledController:
    """Follows `Controller`; its state and gains are flat arrays.

    Args:
        controller: one that can be traced.
        dt: control period, s, which it is traced for.
        faster: makes a function faster that is evaluated at every tick.
    """

    def __init__(
        self,
        controller: TraceableController,
        dt: float,
        faster: Callable[[ca.Function], ca.Function] = lambda function: function,
    ) -> None:
        controller.require(dt)
        robot = controller.robot
        self.name, self.needs, self.robot, self.dt = controller.name, controller.needs, robot, dt
        initial, gains = controller.initial_state(), controller.gains()
        states, gain_layout = Layout(initial), Layout(gains)
        self._initial, self._gains = states.pack(initial), gain_layout.pack(gains)
        zero = zero_reference(robot.n_joints, robot.n_vectoring)
        references = Layout(zero._replace(ahead=(zero,) * len(self.needs.preview)))
        z3 = np.zeros(3)
        measurements = Layout(
            Measurement(z3, np.zeros(4), z3, z3, np.zeros(robot.n_joints), np.zeros(robot.n_vectoring))
        )
        sizes = (states.size, measurements.size, references.size, gain_layout.size)
        x, m, r, p = symbols = [ca.SX.sym(name, size) for name, size in zip("xmrp", sizes, strict=True)]
        new, command, inner = controller.step(
            gain_layout.unpack(p), states.unpack(x), measurements.unpack(m), references.unpack(r), dt
        )
        inner = dict(inner)
        self._commands, self._signals = Layout(command), Layout(inner)
        outputs = [
            ca.densify(part)
            for part in (states.pack(new), self._commands.pack(command), self._signals.pack(inner))
        ]
        function = faster(ca.Function("controller", symbols, outputs, {"cse": True}))
        self._given = [np.zeros(size) for size in sizes]
        self._made = [np.zeros(part.numel()) for part in outputs]
        self._slices = list(self._signals.slices.items())
        self._buffer, self._evaluate = function.buffer()
        array: Any  # the stubs know no buffers
        for index, array in enumerate(self._given):
            self._buffer.set_arg(index, memoryview(array))  # pyright: ignore[reportCallIssue]
        for index, array in enumerate(self._made):
            self._buffer.set_res(index, memoryview(array))  # pyright: ignore[reportCallIssue]

    def gains(self) -> np.ndarray:
        """The gains, flat."""
        return self._gains.copy()

    def initial_state(self) -> np.ndarray:
        """The state before the first tick, flat."""
        return self._initial.copy()

    def step(
        self, gains: np.ndarray, state: np.ndarray, measurement: Measurement, reference: Reference, dt: float
    ) -> tuple[np.ndarray, Command, Mapping[str, Any]]:
        """One tick."""
        given, shapes = self._given, self._signals.shapes
        given[0][:], given[3][:] = state, gains
        np.concatenate(measurement, out=given[1])
        flat = [*reference[:-1], *(entry for ahead in reference.ahead for entry in ahead[:-1])]
        np.concatenate([np.ravel(entry) for entry in flat], out=given[2])
        self._evaluate()
        new, command, signals = (part.copy() for part in self._made)
        own = {
            name: float(signals[part.start]) if shapes[name] == () else signals[part].reshape(shapes[name])
            for name, part in self._slices
        }
        return new, self._commands.unpack(command), own
