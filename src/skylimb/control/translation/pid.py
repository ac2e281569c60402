"""PID of the centre of gravity's position: the paper's baseline, whose gains it does not print."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from skylimb.config import require_positive, require_range
from skylimb.control.records import LawInput
from skylimb.estimation.records import Signals, Start
from skylimb.robots.model import GRAVITY_W
from skylimb.symbolic import Array, clip

Vector3 = tuple[float, float, float]


@dataclass(frozen=True)
class Gains:
    """Gains and limits per axis of W; limits are on the acceleration of a term, m/s^2.

    Attributes:
        proportional: 1/s^2.
        integral: 1/s^3.
        derivative: 1/s.
        proportional_limit: m/s^2.
        integral_limit: m/s^2; the integrator stops there.
        derivative_limit: m/s^2.
        sum_limit: m/s^2, on the three together.
    """

    proportional: Vector3
    integral: Vector3
    derivative: Vector3
    proportional_limit: Vector3
    integral_limit: Vector3
    derivative_limit: Vector3
    sum_limit: Vector3

    def __post_init__(self) -> None:
        for name, unit in (("proportional", "1/s^2"), ("integral", "1/s^3"), ("derivative", "1/s")):
            for entry in getattr(self, name):
                require_range("translation", name, entry, 0.0, 1e3, unit)
        for name in ("proportional_limit", "integral_limit", "derivative_limit", "sum_limit"):
            for entry in getattr(self, name):
                require_positive("translation", name, entry, "m/s^2")


class State(NamedTuple):
    """Acceleration of the integral term, m/s^2, W, (3,)."""

    integral: Array


def initial_state(gains: Gains, start: Start) -> State:
    """An empty integrator."""
    return State(np.zeros(3))


def step(gains: Any, state: State, inputs: LawInput) -> tuple[State, Array, Signals]:
    """f_cmd = m (g + a_ref + P + I + D), W, N, each term within its limit."""
    body, reference = inputs.estimate.body, inputs.reference
    error = reference.position - body.position
    velocity_error = reference.velocity - body.velocity
    integral = state.integral + gains.integral * error * inputs.dt
    integral = clip(integral, -gains.integral_limit, gains.integral_limit)
    proportional = clip(gains.proportional * error, -gains.proportional_limit, gains.proportional_limit)
    derivative = clip(gains.derivative * velocity_error, -gains.derivative_limit, gains.derivative_limit)
    acceleration = clip(proportional + integral + derivative, -gains.sum_limit, gains.sum_limit)
    force = body.model.mass * (acceleration + reference.acceleration + GRAVITY_W)
    return State(integral), force, {}
