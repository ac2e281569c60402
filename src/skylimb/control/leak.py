"""The side force of the rotational thrusts, and its compensation.

eq:thrust rotation 1 and the sentence before it take lambda_r to be a pure torque. With tilted rotors
Q_t pinv(Q_r) is not zero: for hydrus_xi_quad at theta = pi/6 with the tip link along x, a newton metre of
yaw torque pushes with about (1.1, 0.7, -0.5) N in W. On one sign of the board's slope the contact's yaw
torque then unloads the pen, on the other it feeds back positively. Taking the low-passed leak off the wanted
force before the attitude target is formed cures it. Off in the paper's presets.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from skylimb.config import require_positive
from skylimb.symbolic import Array, exp


@dataclass(frozen=True)
class LeakCompensation:
    """Whether the leak is compensated, and how fast.

    Attributes:
        compensate: off in the paper's presets.
        cutoff: of the low pass on the leak, Hz; it must stay below the attitude loop's own bandwidth.
        steady: whether it is the leak of the torque that holds the attitude against the estimated
            disturbance, rather than of the torque that is commanded: free of the attitude loop's own motion,
            it may be followed faster.
    """

    compensate: bool = False
    cutoff: float = 0.5
    steady: bool = False

    def __post_init__(self) -> None:
        require_positive("leak", "cutoff", self.cutoff, "Hz")


class LeakState(NamedTuple):
    """Low-passed leak R Q_t lambda_r in W, N."""

    force: Array


def initial_leak_state() -> LeakState:
    """No leak known."""
    return LeakState(np.zeros(3))


def without_leak(gains: Any, state: LeakState, force: Array) -> Array:
    """The wanted force less what the rotational thrusts are known to add to it, W, N."""
    return force - state.force if gains.compensate else force


def follow_leak(gains: Any, state: LeakState, leak: Array, dt: float) -> LeakState:
    """One step of the low pass on the leak R Q_t lambda_r of this tick."""
    decay = exp(-2.0 * math.pi * gains.cutoff * dt)
    return LeakState(decay * state.force + (1.0 - decay) * leak)
