"""Impedance of the tip's position with matrices in the task frame, eq:imp cmd for trans2 in full.

    f_cmd = (L^-1 - E) f_hat + m (g + p_ref'' - D e' - K e),        e = p - p_ref,    p_ref = p_tip + x - r

with L = M_d / m, and D = C_d M_d^-1 and K = K_d M_d^-1 symmetric matrices in the axes of the task: stiff
across the surface and soft along its normal, in whatever direction that points. p_tip is the tip's reference,
x the way of its target (the contact law's), r from the centre of gravity to the tip as it is now: an attitude
that is off does not move the tip.
"""

from __future__ import annotations

from typing import Annotated, Any

from skylimb.base.keys import Key, Vector3, configuration
from skylimb.control.estimation.records import Signals
from skylimb.control.records import LawInput, no_memory
from skylimb.control.task_frame import COUPLING, impedance, require_definite, task_axes
from skylimb.control.terms import place_terms
from skylimb.symbolic import Array, cross

REQUIRES = ("estimate.body", "estimate.arm", "estimate.wrench", "contact.tip")

_BESIDE = "its entries (au, av, uv)"


@configuration
class Gains:
    """The impedance: diagonals (contact axis, u, v), and what stands beside them."""

    stiffness: Annotated[Vector3, Key("1/s^2", "diagonal of K, stiffness over virtual mass", 0.0, 1e4)] = (
        5.0,
        8.0,
        6.0,
    )
    stiffness_coupling: Annotated[Vector3, Key("1/s^2", _BESIDE, -1e4, 1e4)] = COUPLING
    damping: Annotated[Vector3, Key("1/s", "diagonal of D, damping over virtual mass", 0.0, 1e3)] = (
        4.5,
        4.5,
        4.0,
    )
    damping_coupling: Annotated[Vector3, Key("1/s", _BESIDE, -1e3, 1e3)] = COUPLING
    mass_ratio: Annotated[
        Vector3, Key("", "diagonal of L, virtual over true mass; above 1 it resists disturbances", 0.0, 1e3)
    ] = (1.0, 1.0, 1.0)
    mass_ratio_coupling: Annotated[Vector3, Key("", _BESIDE, -1e3, 1e3)] = COUPLING

    def check(self) -> None:
        """Refuse matrices that would give energy."""
        require_definite(self, "stiffness", "damping", "mass_ratio")


initial_state = no_memory


def step(gains: Any, state: tuple[()], inputs: LawInput) -> tuple[tuple[()], Array, Signals]:
    """f_cmd in W, N, (3,)."""
    estimate, reference, tip = inputs.estimate, inputs.reference, inputs.contact.tip
    body, arm, R_WT = estimate.body, estimate.arm, task_axes(reference)
    target = reference.tip_position + tip.position - arm
    target_velocity = reference.tip_velocity + tip.velocity - cross(tip.rotation_rate, arm)
    error, error_rate = R_WT.T @ (body.position - target), R_WT.T @ (body.velocity - target_velocity)
    felt = R_WT.T @ estimate.wrench.force
    feedback, spring, damper = impedance(gains, "mass_ratio", error, error_rate, felt)
    m = body.model.mass
    # The centre of gravity goes around the tip where the target turns.
    acceleration = reference.tip_acceleration - cross(tip.rotation_rate, cross(tip.rotation_rate, arm))
    force = R_WT @ (feedback - m * (spring + damper)) + m * (body.model.gravity + acceleration)
    return (
        state,
        force,
        {"cog_position_target": target, **place_terms(-(R_WT @ spring), -(R_WT @ damper))},
    )
