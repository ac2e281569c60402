"""One tick of a controller on symbols: as a function of flat vectors, and what stands where in them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.packing import Layout
from skylimb.base.split_function import PythonCall, split_function
from skylimb.control.estimation.records import Measurement, zero_measurement
from skylimb.control.missions.reference import Reference, zero_reference
from skylimb.control.needs import needs_of
from skylimb.control.records import Command


class StepInputs(NamedTuple):
    """Where the entries of a step's arguments stand, in the order of the traced function."""

    state: Layout[Any]
    measurement: Layout[Measurement]
    reference: Layout[Reference]
    gains: Layout[Any]


def step_inputs(controller: Any, ahead: int = 0) -> StepInputs:
    """The arguments of a controller's step.

    Args:
        controller: a `control.controller.TraceableController`.
        ahead: how many references ahead of its own a reference holds.
    """
    robot = controller.robot
    zero = zero_reference(robot.n_joints, robot.n_vectoring)
    return StepInputs(
        Layout(controller.initial_state()),
        Layout(zero_measurement(robot.n_joints, robot.n_vectoring, needs_of(controller).imu)),
        Layout(zero._replace(ahead=(zero,) * ahead)),
        Layout(controller.gains()),
    )


def symbolic_inputs(inputs: StepInputs) -> tuple[list[ca.SX], list[Any]]:
    """Symbols for a step's arguments: each as a flat vector, and as the record that a step takes."""
    symbols = [ca.SX.sym(name, layout.size) for name, layout in inputs._asdict().items()]
    return symbols, [layout.unpack(flat) for layout, flat in zip(inputs, symbols, strict=True)]


@dataclass(frozen=True)
class TracedStep:
    """One tick of a controller, every record a flat vector.

    Attributes:
        function: (state, measurement, reference, gains) -> (next_state, command, signals).
        inputs: where the entries of its arguments stand.
        state: before the first tick.
        gains: of the controller.
        commands: where the entries of a command stand.
        signals: where the signals that the controller records stand.
        calls: laws in plain Python in the middle of the function.
    """

    function: ca.Function
    inputs: StepInputs
    state: np.ndarray
    gains: np.ndarray
    commands: Layout[Command]
    signals: Layout[dict[str, Any]]
    calls: tuple[PythonCall, ...] = ()


def traced_step(controller: Any, dt: float, ahead: int = 0, name: str = "controller") -> TracedStep:
    """Trace a tick of `dt` seconds.

    Args:
        controller: a `control.controller.TraceableController`.
        dt: control period, s.
        ahead: how many references ahead of its own a reference holds.
        name: of the function.

    Raises:
        ConfigError: where the controller cannot work at this control period, or its new state has other
            shapes than its initial one.
    """
    controller.require(dt)
    inputs = step_inputs(controller, ahead)
    symbols, (state, measurement, reference, gains) = symbolic_inputs(inputs)
    traced, asked = controller.opened()
    new, command, signals = traced.step(gains, state, measurement, reference, dt)
    states, commands, recorded = inputs.state, Layout(command), Layout(dict(signals))
    if Layout(new).slices != states.slices:
        raise ConfigError(
            f"the new state of controller '{controller.name}' has the shapes {Layout(new).shapes}, its "
            f"initial state {states.shapes}; numbers of the state are floats, 0.0 and not 0"
        )
    outputs = states.pack(new), commands.pack(command), recorded.pack(dict(signals))
    names = StepInputs._fields, ("next_state", "command", "signals")
    function, calls = split_function(name, symbols, outputs, names, asked)
    start = states.pack(controller.initial_state()), inputs.gains.pack(controller.gains())
    return TracedStep(function, inputs, *start, commands, recorded, calls)
