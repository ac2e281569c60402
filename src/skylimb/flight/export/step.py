"""The controller alone, without simulated sensors and actuators, as one function of flat vectors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from skylimb.base.packing import Layout
from skylimb.control.controller import TraceableController
from skylimb.control.estimation.records import Measurement
from skylimb.control.missions.reference import Reference, zero_reference
from skylimb.control.planning.posture import posture_family
from skylimb.control.planning.vectoring import vectoring_table
from skylimb.control.records import Command
from skylimb.robots.model import Robot

NAME = "skylimb_controller_function"


@dataclass(frozen=True)
class ControllerStep:
    """One control tick of a cascade.

    Attributes:
        function: (state, measurement, reference, gains) -> (next_state, command, signals), all flat.
        state: before the first tick, flat.
        gains: of the preset, flat.
        measurements: layout of a measurement.
        references: layout of a reference.
        gains_layout: of the gains.
        commands: layout of a command.
        signals: layout of the controller's inner signals.
    """

    function: ca.Function
    state: np.ndarray
    gains: np.ndarray
    measurements: Layout[Measurement]
    references: Layout[Reference]
    gains_layout: Layout[Any]
    commands: Layout[Command]
    signals: Layout[dict[str, Any]]


def controller_step(controller: TraceableController, dt: float) -> ControllerStep:
    """Trace a cascade's tick for control period `dt`, s."""
    controller.require(dt)
    initial, gains = controller.initial_state(), controller.gains()
    states, gains_layout = Layout(initial), Layout(gains)
    robot = controller.robot
    measurements = Layout(_measurement(robot))
    references = Layout(zero_reference(robot.n_joints, robot.n_vectoring))
    sizes = (
        ("state", states.size),
        ("measurement", measurements.size),
        ("reference", references.size),
        ("gains", gains_layout.size),
    )
    x, m, r, p = symbols = [ca.SX.sym(name, size) for name, size in sizes]
    new, command, inner = controller.step(
        gains_layout.unpack(p), states.unpack(x), measurements.unpack(m), references.unpack(r), dt
    )
    inner = dict(inner)
    commands, signals = Layout(command), Layout(inner)
    function = ca.Function(
        NAME,
        symbols,
        [ca.densify(out) for out in (states.pack(new), commands.pack(command), signals.pack(inner))],
        [name for name, _ in sizes],
        ["next_state", "command", "signals"],
        {"cse": True},
    )
    return ControllerStep(
        function,
        states.pack(initial),
        gains_layout.pack(gains),
        measurements,
        references,
        gains_layout,
        commands,
        signals,
    )


def _measurement(robot: Robot) -> Measurement:
    z3 = np.zeros(3)
    return Measurement(z3, np.zeros(4), z3, z3, np.zeros(robot.n_joints), np.zeros(robot.n_vectoring))


class Vector(NamedTuple):
    """What the exported code is held against, one row a tick.

    Attributes:
        measurement: given.
        reference: given.
        command: wanted.
        signals: wanted.
    """

    measurement: np.ndarray
    reference: np.ndarray
    command: np.ndarray
    signals: np.ndarray


TICKS = 60
_TARE, _ADAPT = (10, 20), 30  # ticks at which the bias is averaged, and from which the arm may give way


def example_vector(controller: TraceableController, step: ControllerStep, seed: int = 0) -> Vector:
    """A hovering robot that is shaken about, and then pushed back: every law has something to do."""
    rng, robot = np.random.default_rng(seed), controller.robot
    family = posture_family(robot)
    theta, reach = family.theta_nominal, family.reach_nominal
    q, psi = family.joint_angles(theta), vectoring_table(robot, controller.needs.vectoring).angles(theta)
    hover = robot.at(q, psi)
    home, a = np.array([0.0, 0.0, 1.2]), np.array([1.0, 0.0, 0.0])
    state, rows = step.state, []
    for k in range(TICKS):
        tare, adapt = float(_TARE[0] <= k < _TARE[1]), float(k >= _ADAPT)
        reference = zero_reference(len(q), len(psi))._replace(
            position=home,
            reach=reach,
            joint_angles=q,
            vectoring_angles=psi,
            contact_axis=a,
            tare=tare,
            align=adapt,
            adapt=adapt,
            tip_position=home + reach * a,
            touch=adapt,
            sliding_axis=np.array([0.0, 1.0, 0.0]),
        )
        turn = 0.5 * rng.normal(scale=0.02, size=3)
        measurement = Measurement(
            home - hover.cog_root + rng.normal(scale=0.02, size=3) - 0.001 * max(0, k - _ADAPT) * a,
            np.concatenate([[1.0], turn]) / np.sqrt(1.0 + turn @ turn),
            rng.normal(scale=0.05, size=3),
            rng.normal(scale=0.1, size=3),
            q + rng.normal(scale=0.01, size=len(q)),
            psi + rng.normal(scale=0.01, size=len(psi)),
        )
        given = step.measurements.pack(measurement), step.references.pack(reference)
        state, command, signals = (
            np.asarray(out).ravel() for out in step.function(state, *given, step.gains)
        )
        rows.append((*given, command, signals))
    return Vector(*(np.array(column) for column in zip(*rows, strict=True)))
