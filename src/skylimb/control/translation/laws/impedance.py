"""Impedance of the centre of gravity, eq:imp cmd for trans2."""

from __future__ import annotations

from typing import Annotated, Any

from skylimb.base.keys import Key, Vector3, configuration
from skylimb.control.estimation.records import Signals
from skylimb.control.records import LawInput, no_memory
from skylimb.control.terms import place_terms
from skylimb.symbolic import Array

REQUIRES = ("estimate.body", "estimate.wrench")


@configuration
class Gains:
    """The impedance along the axes of W; C_td / M_d = 2 Z_td sqrt(K_td / M_d), eq:damping rate.

    Above a mass ratio of one, the robot feels heavier than it is, and resists disturbances.
    """

    virtual_mass_ratio: Annotated[
        Vector3,
        Key("", "virtual over true mass, M_d / m; above 1 it resists disturbances", above=0.0, high=1e3),
    ]
    normalized_stiffness: Annotated[Vector3, Key("1/s^2", "stiffness K_td / M_d", above=0.0, high=1e4)]
    damping_ratio: Annotated[Vector3, Key("", "damping ratio Z_td of eq:damping rate", above=0.0, high=100.0)]


initial_state = no_memory


def step(gains: Any, state: tuple[()], inputs: LawInput) -> tuple[tuple[()], Array, Signals]:
    """f_cmd of eq:imp cmd for trans2, W, N, plus the reference's acceleration (zero when it is not sent)."""
    body, reference = inputs.estimate.body, inputs.reference
    mass = body.model.mass
    error = body.position - reference.position
    velocity_error = body.velocity - reference.velocity
    damping = 2.0 * gains.damping_ratio * gains.normalized_stiffness**0.5
    feedback = (1.0 / gains.virtual_mass_ratio - 1.0) * inputs.estimate.wrench.force
    damper, spring = damping * velocity_error, gains.normalized_stiffness * error
    force = feedback + mass * (reference.acceleration - (damper + spring) + body.model.gravity)
    return state, force, place_terms(-spring, -damper)
