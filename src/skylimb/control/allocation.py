"""From wanted force and torque to thrusts, eq:thrust translation 1 to eq:thrust."""

from __future__ import annotations

from typing import NamedTuple

from skylimb.robots.model import GRAVITY, RobotState
from skylimb.symbolic import Array, clip, right_inverse, stack


class Thrusts(NamedTuple):
    """Thrusts in N, (n,).

    Attributes:
        total: lambda of eq:thrust within the rotors' limits: what the rotors are told.
        rotation: lambda_r of eq:thrust rotation 1 before the limits, from which the leak is known.
    """

    total: Array
    rotation: Array


def allocate(
    model: RobotState,
    R_WC: Array,
    force: Array,
    torque: Array,
    thrust_min: Array,
    thrust_max: Array,
    hold_lift: bool = False,
) -> Thrusts:
    """Lambda = lambda_t + lambda_r, held within the limits.

    eq:thrust translation 2 prints m f_cmd; f_cmd is a force already, and with the mass the robot leaves in
    0.6 s.

    Args:
        model: allocation matrix at the measured angles.
        R_WC: rotation of C seen from W.
        force: f_cmd in W, N.
        torque: tau_cmd in C, N m.
        thrust_min: N, (n,).
        thrust_max: N, (n,).
        hold_lift: whether lambda_r is chosen so that it does not lift, [Q_tz; Q_r] lambda_r = [0; tau_cmd],
            where the paper takes the least-norm one.
    """
    Q = model.allocation_C
    wanted = R_WC[:, 2].T @ force
    # The thrusts that lift without turning, eq:thrust translation 2, are the hover thrusts in proportion:
    # those solve the same four rows for the weight.
    lifting = model.hover_thrusts * (wanted / (model.mass * GRAVITY))
    rotation = right_inverse(Q[2:, :]) @ stack(0.0, torque) if hold_lift else right_inverse(Q[3:, :]) @ torque
    return Thrusts(clip(lifting + rotation, thrust_min, thrust_max), rotation)


def rotor_wrench(model: RobotState, R_WC: Array, thrusts: Array) -> tuple[Array, Array]:
    """What the rotors do, eq:allocation for wrench: force in W (N) and torque in C (N m)."""
    wrench = model.allocation_C @ thrusts
    return R_WC @ wrench[0:3], wrench[3:6]
