"""A controller whose step is one compiled function: the same numbers, much faster than in Python."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import casadi as ca
import numpy as np

from skylimb.base.bound_function import BoundFunction
from skylimb.base.packing import flattened
from skylimb.base.split_function import made_faster
from skylimb.control.estimation.records import Measurement
from skylimb.control.laws.traced_step import traced_step
from skylimb.control.missions.reference import Reference
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
        controller: Any,
        dt: float,
        faster: Callable[[ca.Function], ca.Function] = lambda function: function,
    ) -> None:
        step = made_faster(traced_step(controller, dt, len(controller.needs.preview)), faster)
        self.name, self.needs = controller.name, controller.needs
        self.robot, self.dt = controller.robot, dt
        self._initial, self._gains, self._commands, self._signals = (
            step.state,
            step.gains,
            step.commands,
            step.signals,
        )
        function = step.function
        self.gain_layout = step.inputs[3]
        self._given = [np.zeros(layout.size) for layout in step.inputs]
        self._made = [np.zeros(function.numel_out(index)) for index in range(function.n_out())]
        self._bound = BoundFunction(function, self._given, self._made, step.calls)

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
        given = self._given
        given[0][:], given[3][:] = state, gains
        # An IMU that nobody needs is left out.
        given[1][:] = flattened(measurement.entries)[: len(given[1])]
        given[2][:] = flattened(reference.entries)
        self._bound.evaluate()
        new, command, signals = (part.copy() for part in self._made)
        return new, self._commands.unpack(command), self._signals.unpack(signals)
