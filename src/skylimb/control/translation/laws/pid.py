"""PID of the centre of gravity's position: the paper's baseline, whose gains it does not print."""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

import numpy as np

from skylimb.base.keys import Key, Vector3, configuration
from skylimb.control.estimation.records import Signals, Start
from skylimb.control.records import NOTHING, LawInput
from skylimb.control.terms import place_terms
from skylimb.control.windup import unless_short
from skylimb.symbolic import Array, clip

REQUIRES = ("estimate.body",)
OPTIONAL = {"residual": ""}


@configuration
class Gains:
    """Gains and limits along the axes of W; a limit is on the acceleration that a term gives."""

    proportional: Annotated[Vector3, Key("1/s^2", "gain of the position error", low=0.0, high=1e3)]
    integral: Annotated[Vector3, Key("1/s^3", "gain of the position error's integral", low=0.0, high=1e3)]
    derivative: Annotated[Vector3, Key("1/s", "gain of the velocity error", low=0.0, high=1e3)]
    proportional_limit: Annotated[
        Vector3, Key("m/s^2", "greatest size of the proportional term", above=0.0, high=1e3)
    ]
    integral_limit: Annotated[
        Vector3,
        Key("m/s^2", "greatest size of the integral term; the integrator stops there", above=0.0, high=1e3),
    ]
    derivative_limit: Annotated[
        Vector3, Key("m/s^2", "greatest size of the derivative term", above=0.0, high=1e3)
    ]
    sum_limit: Annotated[Vector3, Key("m/s^2", "greatest size of the three together", above=0.0, high=1e3)]


class State(NamedTuple):
    """Acceleration of the integral term, m/s^2, W, (3,)."""

    integral: Array


def initial_state(gains: Gains, start: Start) -> State:
    """An empty integrator."""
    return State(np.zeros(3))


def step(gains: Any, state: State, inputs: LawInput) -> tuple[State, Array, Signals]:
    """f_cmd = m (g + a_ref + P + I + D), W, N, each term within its limit.

    The integral holds along an axis along which the rotors fall short.
    """
    body, reference = inputs.estimate.body, inputs.reference
    error = reference.position - body.position
    velocity_error = reference.velocity - body.velocity
    short = inputs.residual or NOTHING
    growth = gains.integral * error * inputs.dt
    integral = state.integral + unless_short(growth, short.force)
    integral = clip(integral, -gains.integral_limit, gains.integral_limit)
    proportional = clip(gains.proportional * error, -gains.proportional_limit, gains.proportional_limit)
    derivative = clip(gains.derivative * velocity_error, -gains.derivative_limit, gains.derivative_limit)
    acceleration = clip(proportional + integral + derivative, -gains.sum_limit, gains.sum_limit)
    force = body.model.mass * (acceleration + reference.acceleration + body.model.gravity)
    return State(integral), force, place_terms(proportional, derivative, integral)
