"""The filtered contact force f_hat of eq:admittance control: a first-order low pass, held exactly."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from skylimb.symbolic import Array, exp


class ForceFilterState(NamedTuple):
    """The filtered force along the contact axis, N; negative when the robot is pushed back."""

    force: float | Array


def filter_force(cutoff: Any, state: ForceFilterState, force: Any, dt: float) -> tuple[ForceFilterState, Any]:
    """One step of the low pass with `cutoff` in Hz; returns the new state and f_hat in N."""
    decay = exp(-2.0 * math.pi * cutoff * dt)
    filtered = decay * state.force + (1.0 - decay) * force
    return ForceFilterState(filtered), filtered
