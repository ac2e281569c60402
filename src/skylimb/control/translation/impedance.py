"""Impedance of the centre of gravity, eq:imp cmd for trans2."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from skylimb.config import require_positive
from skylimb.control.records import LawInput
from skylimb.estimation.records import Signals, Start
from skylimb.robots.model import GRAVITY_W
from skylimb.symbolic import Array


@dataclass(frozen=True)
class Gains:
    """The impedance in W, per axis.

    Attributes:
        virtual_mass_ratio: M_d / m. Above one the robot feels heavier than it is, and resists disturbances.
        normalized_stiffness: K_td / M_d, 1/s^2.
        damping_ratio: Z_td of eq:damping rate; C_td / M_d = 2 Z_td sqrt(K_td / M_d).
    """

    virtual_mass_ratio: tuple[float, float, float]
    normalized_stiffness: tuple[float, float, float]
    damping_ratio: tuple[float, float, float]

    def __post_init__(self) -> None:
        for name, unit in (
            ("virtual_mass_ratio", ""),
            ("normalized_stiffness", "1/s^2"),
            ("damping_ratio", ""),
        ):
            for entry in getattr(self, name):
                require_positive("translation", name, entry, unit)


def initial_state(gains: Gains, start: Start) -> tuple[()]:
    """An impedance has no memory of its own."""
    return ()


def step(gains: Any, state: tuple[()], inputs: LawInput) -> tuple[tuple[()], Array, Signals]:
    """f_cmd of eq:imp cmd for trans2, W, N, plus the reference's acceleration (zero when it is not sent)."""
    body, reference = inputs.estimate.body, inputs.reference
    mass = body.model.mass
    error = body.position - reference.position
    velocity_error = body.velocity - reference.velocity
    damping = 2.0 * gains.damping_ratio * gains.normalized_stiffness**0.5
    feedback = (1.0 / gains.virtual_mass_ratio - 1.0) * inputs.estimate.wrench.force
    spring = damping * velocity_error + gains.normalized_stiffness * error
    force = feedback + mass * (reference.acceleration - spring + GRAVITY_W)
    return state, force, {}
