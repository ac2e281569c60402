"""The controller alone, without simulated sensors and actuators, as one function of flat vectors."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from skylimb.control.controller import TraceableController
from skylimb.control.estimation.records import Measurement
from skylimb.control.missions.reference import zero_reference
from skylimb.control.planning.posture import posture_family
from skylimb.control.planning.vectoring import vectoring_table
from skylimb.control.traced_step import TracedStep, traced_step

NAME = "skylimb_controller_function"


def controller_step(controller: TraceableController, dt: float) -> TracedStep:
    """A controller's tick of `dt` seconds, as its C has it: a reference shows nothing that lies ahead."""
    return traced_step(controller, dt, name=NAME)


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


def example_vector(controller: TraceableController, step: TracedStep, seed: int = 0) -> Vector:
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
        given = step.inputs.measurement.pack(measurement), step.inputs.reference.pack(reference)
        state, command, signals = (
            np.asarray(out).ravel() for out in step.function(state, *given, step.gains)
        )
        rows.append((*given, command, signals))
    return Vector(*(np.array(column) for column in zip(*rows, strict=True)))
