"""Rotational impedance, eq:imp cmd for rot2."""

from __future__ import annotations

from typing import Annotated, Any

from skylimb.base.keys import Key, Vector3, configuration
from skylimb.base.rotations import rotation_error
from skylimb.control.estimation.records import Signals
from skylimb.control.records import LawInput, no_memory
from skylimb.control.terms import turn_terms
from skylimb.symbolic import Array, cross

REQUIRES = ("estimate.body", "estimate.wrench")


@configuration
class Gains:
    """The impedance about the axes of C.

    Above a ratio of one, the estimated torque is fed back to resist it.
    """

    virtual_inertia_ratio: Annotated[
        Vector3,
        Key("", "virtual over true inertia, I_d I^-1; above 1 it resists disturbances", above=0.0, high=1e3),
    ]
    normalized_stiffness: Annotated[Vector3, Key("1/s^2", "stiffness K_rd / I_d", above=0.0, high=1e5)]
    damping_ratio: Annotated[Vector3, Key("", "damping ratio Z_rd of eq:damping rate", above=0.0, high=100.0)]


initial_state = no_memory


def step(gains: Any, state: tuple[()], inputs: LawInput, R_target: Array) -> tuple[tuple[()], Array, Signals]:
    """tau_cmd of eq:imp cmd for rot2, C, N m, for a target that does not turn (omega_ref = 0).

    e_alpha of the printed equation is e_R of eq:error of rotation.
    """
    body = inputs.estimate.body
    inertia, omega = body.model.inertia_C, body.angular_velocity
    damping = 2.0 * gains.damping_ratio * gains.normalized_stiffness**0.5
    damper = damping * omega
    spring = gains.normalized_stiffness * rotation_error(body.R_WC, R_target)
    feedback = (1.0 / gains.virtual_inertia_ratio - 1.0) * inputs.estimate.wrench.torque
    torque = feedback - inertia @ (damper + spring) + cross(omega, inertia @ omega)
    return state, torque, turn_terms(-spring, -damper)
