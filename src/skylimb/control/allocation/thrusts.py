"""From wanted force and torque to thrusts, eq:thrust translation 1 to eq:thrust."""

from __future__ import annotations

from typing import NamedTuple

from skylimb.control.allocation.rotor_reaction import Reaction
from skylimb.control.estimation.records import BodyState
from skylimb.symbolic import Array, clip, right_inverse, stack

Limits = tuple[Array, Array]
"""Least and greatest thrust, N, (n,) each."""


class Thrusts(NamedTuple):
    """Thrusts in N, (n,).

    Attributes:
        total: lambda of eq:thrust.
        rotation: lambda_r of eq:thrust rotation 1 without limits, from which the leak is known.
    """

    total: Array
    rotation: Array


def allocate(
    body: BodyState,
    force: Array,
    torque: Array,
    limits: Limits,
    hold_lift: bool = False,
    reaction: Reaction | None = None,
) -> Thrusts:
    """Lambda = lambda_t + lambda_r, cut off at the limits; for the arguments see `unlimited`.

    Args:
        body: attitude and allocation matrix.
        force: f_cmd in W, N.
        torque: tau_cmd in C, N m.
        limits: of the thrusts, N.
        hold_lift: whether lambda_r does not lift.
        reaction: of the rotors, where it is known.
    """
    wanted = unlimited(body, force, torque, hold_lift, reaction)
    return wanted._replace(total=clip(wanted.total, limits[0], limits[1]))


def unlimited(
    body: BodyState, force: Array, torque: Array, hold_lift: bool = False, reaction: Reaction | None = None
) -> Thrusts:
    """Lambda = lambda_t + lambda_r as if rotors had no limits.

    eq:thrust translation 2 prints m f_cmd; f_cmd is a force already, and with the mass the robot leaves in
    0.6 s.

    Args:
        body: attitude, and the allocation matrix at the measured angles.
        force: f_cmd in W, N.
        torque: tau_cmd in C, N m.
        hold_lift: whether lambda_r is chosen so that it does not lift, [Q_tz; Q_r] lambda_r = [0; tau_cmd],
            where the paper takes the least-norm one.
        reaction: of the rotors, where it is known; the torque is then given with it.
    """
    model = body.model
    Q = model.allocation_C
    wanted = body.R_WC[:, 2].T @ force
    # The thrusts that lift without turning, eq:thrust translation 2, are the hover thrusts in proportion:
    # those solve the same four rows for the weight.
    lifting = model.hover_thrusts * (wanted / (model.mass * model.gravity[2]))
    if reaction is not None:
        Q = Q + reaction.matrix
        torque = torque + reaction.matrix[3:, :] @ (reaction.thrusts - lifting)
    rotation = right_inverse(Q[2:, :]) @ stack(0.0, torque) if hold_lift else right_inverse(Q[3:, :]) @ torque
    return Thrusts(lifting + rotation, rotation)
