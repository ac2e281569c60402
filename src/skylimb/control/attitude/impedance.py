"""Rotational impedance, eq:imp cmd for rot2."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from skylimb.config import require_positive
from skylimb.control.records import LawInput
from skylimb.estimation.records import Signals, Start
from skylimb.spatial import cross, rotation_error
from skylimb.symbolic import Array


@dataclass(frozen=True)
class Gains:
    """The impedance in C, per axis.

    Attributes:
        virtual_inertia_ratio: I_d I^-1. Above one the estimated torque is fed back to resist it.
        normalized_stiffness: K_rd / I_d, 1/s^2.
        damping_ratio: Z_rd of eq:damping rate.
    """

    virtual_inertia_ratio: tuple[float, float, float]
    normalized_stiffness: tuple[float, float, float]
    damping_ratio: tuple[float, float, float]

    def __post_init__(self) -> None:
        for name, unit in (
            ("virtual_inertia_ratio", ""),
            ("normalized_stiffness", "1/s^2"),
            ("damping_ratio", ""),
        ):
            for entry in getattr(self, name):
                require_positive("attitude", name, entry, unit)


def initial_state(gains: Gains, start: Start) -> tuple[()]:
    """An impedance has no memory of its own."""
    return ()


def step(gains: Any, state: tuple[()], inputs: LawInput, R_target: Array) -> tuple[tuple[()], Array, Signals]:
    """tau_cmd of eq:imp cmd for rot2, C, N m, for a target that does not turn (omega_ref = 0).

    e_alpha of the printed equation is e_R of eq:error of rotation.
    """
    body = inputs.estimate.body
    inertia, omega = body.model.inertia_C, body.angular_velocity
    damping = 2.0 * gains.damping_ratio * gains.normalized_stiffness**0.5
    spring = damping * omega + gains.normalized_stiffness * rotation_error(body.R_WC, R_target)
    feedback = (1.0 / gains.virtual_inertia_ratio - 1.0) * inputs.estimate.wrench.torque
    return state, feedback - inertia @ spring + cross(omega, inertia @ omega), {}
