"""From an observer's wrench to the estimate that the laws see: tare, filtered contact force and arm."""

from __future__ import annotations

from typing import Any, NamedTuple

from skylimb.base.rotations import rpy_from_rotation
from skylimb.control.estimation.force_filter import filter_force
from skylimb.control.estimation.records import BodyState, Estimate, Sensed, Signals, Wrench
from skylimb.control.estimation.tare import TareState, tare
from skylimb.symbolic import dot


class PushState(NamedTuple):
    """State of the tare, and the filtered contact force, N."""

    tare: TareState = TareState()
    contact_force: Any = 0.0


def estimate_of(
    gains: Any, state: PushState, body: BodyState, raw: Wrench, sensed: Sensed
) -> tuple[PushState, Estimate]:
    """The estimate of a tick, but for what the rotors would have to make up.

    Args:
        gains: with `tare` (whether the bias is taken off) and `force_filter` (a `ForceFilter`).
        state: of the last tick.
        body: state of {C}.
        raw: external wrench as the observer has it, with its bias.
        sensed: of this tick.
    """
    reference = sensed.reference
    bias, tared = tare(state.tare, raw, rpy_from_rotation(body.R_WC)[2], reference.tare)
    wrench = tared if gains.tare else raw
    pushed = dot(wrench.force, reference.contact_axis)
    contact_force = filter_force(gains.force_filter, state.contact_force, pushed, sensed.dt)
    arm = body.R_WC @ body.model.tip_C
    return PushState(bias, contact_force), Estimate(body, wrench, raw, contact_force, arm)


def wrench_signals(known: Estimate) -> Signals:
    """What is recorded of the external wrench, as far as it is estimated."""
    wrench, raw, signals = known.wrench, known.raw, Signals()
    if wrench is not None:
        signals |= {"external_force_estimate": wrench.force, "external_torque_estimate": wrench.torque}
    if known.contact_force is not None:
        signals["external_force_filtered"] = known.contact_force
    if wrench is not None and raw is not None:
        signals["external_force_bias"] = raw.force - wrench.force
        signals["external_torque_bias"] = raw.torque - wrench.torque
    return signals
