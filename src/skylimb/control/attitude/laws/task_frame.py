"""Impedance of the attitude with matrices in the task frame, eq:imp cmd for rot2 in full.

    tau_cmd = (L^-1 - E) tau_hat - I (D (omega - omega_ref) + K e_R) + omega x I omega

with L = I_d I^-1, D and K symmetric matrices in the axes of the task, and e_R of eq:error of rotation against
the target attitude turned by the contact law's rotation of the tip. The rest is seen in the axes of the task
for the matrices, and turned back.
"""

from __future__ import annotations

from typing import Annotated, Any

from skylimb.base.keys import Key, Vector3, configuration
from skylimb.base.rotations import rotation_error, rotation_from_vector
from skylimb.control.estimation.records import Signals
from skylimb.control.records import LawInput, no_memory
from skylimb.control.task_frame import COUPLING, impedance, require_definite, task_axes
from skylimb.control.terms import turn_terms
from skylimb.symbolic import Array, cross

REQUIRES = ("estimate.body", "estimate.wrench", "contact.tip")

_BESIDE = "its entries (au, av, uv)"


@configuration
class Gains:
    """The impedance: diagonals (about the contact axis, u, v), and what stands beside them."""

    stiffness: Annotated[Vector3, Key("1/s^2", "diagonal of K, stiffness over virtual inertia", 0.0, 1e5)] = (
        40.0,
        40.0,
        20.0,
    )
    stiffness_coupling: Annotated[Vector3, Key("1/s^2", _BESIDE, -1e5, 1e5)] = COUPLING
    damping: Annotated[Vector3, Key("1/s", "diagonal of D, damping over virtual inertia", 0.0, 1e3)] = (
        14.0,
        14.0,
        8.0,
    )
    damping_coupling: Annotated[Vector3, Key("1/s", _BESIDE, -1e3, 1e3)] = COUPLING
    inertia_ratio: Annotated[
        Vector3,
        Key("", "diagonal of L, virtual over true inertia; above 1 it resists disturbances", 0.0, 1e3),
    ] = (10.0, 10.0, 5.0)
    inertia_ratio_coupling: Annotated[Vector3, Key("", _BESIDE, -1e3, 1e3)] = COUPLING

    def check(self) -> None:
        """Refuse matrices that would give energy."""
        require_definite(self, "stiffness", "damping", "inertia_ratio")


initial_state = no_memory


def step(gains: Any, state: tuple[()], inputs: LawInput, R_target: Array) -> tuple[tuple[()], Array, Signals]:
    """tau_cmd, C, N m, (3,)."""
    body, tip = inputs.estimate.body, inputs.contact.tip
    inertia, omega = body.model.inertia_C, body.angular_velocity
    R_TC = task_axes(inputs.reference).T @ body.R_WC
    R_target = rotation_from_vector(tip.rotation) @ R_target
    error = R_TC @ rotation_error(body.R_WC, R_target)
    error_rate = R_TC @ (omega - body.R_WC.T @ tip.rotation_rate)
    felt = R_TC @ inputs.estimate.wrench.torque
    feedback, spring, damper = impedance(gains, "inertia_ratio", error, error_rate, felt)
    torque = R_TC.T @ feedback - inertia @ (R_TC.T @ (spring + damper)) + cross(omega, inertia @ omega)
    return state, torque, turn_terms(-(R_TC.T @ spring), -(R_TC.T @ damper))
