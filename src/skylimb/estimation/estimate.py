"""From an observer's wrench to the estimate that the laws see: tare, filtered contact force and arm."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from skylimb.estimation.force_filter import filter_force
from skylimb.estimation.records import BodyState, Estimate, Sensed, Wrench
from skylimb.estimation.tare import TareState, initial_tare_state, tare
from skylimb.spatial import dot, rpy_from_rotation


class PushState(NamedTuple):
    """State of the tare, and the filtered contact force, N."""

    tare: TareState
    contact_force: Any


def initial_push_state() -> PushState:
    """No bias known, no contact."""
    return PushState(initial_tare_state(), 0.0)


def estimate_of(
    gains: Any, state: PushState, body: BodyState, raw: Wrench, sensed: Sensed
) -> tuple[PushState, Estimate]:
    """The estimate of a tick; nothing that the rotors would have to make up.

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
    nothing = Wrench(np.zeros(3), np.zeros(3))
    arm = body.R_WC @ body.model.tip_C
    return PushState(bias, contact_force), Estimate(body, wrench, raw, contact_force, arm, nothing)
