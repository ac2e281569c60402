"""The controller alone, without simulated sensors and actuators, as one function of flat vectors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from skylimb.control.controller import TraceableController
from skylimb.control.laws.traced_step import TracedStep, traced_step
from skylimb.control.laws.user_trace import shaken_hover
from skylimb.control.supervisor.limits import Limits
from skylimb.control.supervisor.supervised import Supervised

NAME = "skylimb_controller_function"


def controller_step(controller: TraceableController, dt: float, limits: Limits | None = None) -> TracedStep:
    """A supervised controller's tick of `dt` seconds; in its C a reference shows nothing that lies ahead."""
    return traced_step(Supervised(controller, limits or Limits()), dt, name=NAME)


Vector = dict[str, np.ndarray]
"""What the exported code is held against, one row a tick: measurement, reference, command and signals."""

TICKS = 60
_TARE, _ADAPT = (10, 20), 30  # ticks at which the bias is averaged, and from which the arm may give way


def example_vector(controller: TraceableController, step: TracedStep) -> Vector:
    """A hovering robot that is shaken about, and then pushed back: every law has something to do."""
    rng, state, rows = np.random.default_rng(0), step.state, []
    for k in range(TICKS):
        measurement, reference = shaken_hover(controller.robot, rng, replace(controller.needs, preview=()))
        tare, adapt = float(_TARE[0] <= k < _TARE[1]), float(k >= _ADAPT)
        pushed = measurement.position - 0.001 * max(0, k - _ADAPT) * reference.contact_axis
        measurement = measurement._replace(position=pushed)
        reference = reference._replace(tare=tare, align=adapt, adapt=adapt, touch=adapt)
        given = step.inputs.measurement.pack(measurement), step.inputs.reference.pack(reference)
        state, command, signals = (
            np.asarray(out).ravel() for out in step.function(state, *given, step.gains)
        )
        rows.append((*given, command, signals))
    columns = map(np.array, zip(*rows, strict=True))
    return dict(zip(("measurement", "reference", "command", "signals"), columns, strict=True))
