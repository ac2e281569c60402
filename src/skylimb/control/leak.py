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
from typing import Any

from skylimb.config import require_positive
from skylimb.control.records import LawInput
from skylimb.control.thrusts import Thrusts, rotor_wrench
from skylimb.symbolic import Array, low_pass, right_inverse, stack


@dataclass(frozen=True)
class Leak:
    """Whether the leak is compensated, and how fast.

    Attributes:
        compensate: off in the paper's presets.
        cutoff: of the low pass on the leak, Hz; it must stay below the attitude loop's own bandwidth.
    """

    compensate: bool = False
    cutoff: float = 0.5

    def __post_init__(self) -> None:
        require_positive("leak", "cutoff", self.cutoff, "Hz")


@dataclass(frozen=True)
class TorqueLeak(Leak):
    """The leak of the rotational thrusts alone.

    Attributes:
        steady: whether it is the leak of the torque that holds the attitude against the estimated
            disturbance, rather than of the torque that is commanded. It is free of the attitude loop's own
            motion, so it may be followed faster.
    """

    steady: bool = False


def without_leak(gains: Any, leak: Array, force: Array) -> Array:
    """The wanted force less the known leak, W, N."""
    return force - leak if gains.compensate else force


def side_force(gains: Any, inputs: LawInput, thrusts: Thrusts) -> Array:
    """R Q_t lambda_r, W, N, (3,): the force of the thrusts that turn the robot, or that hold its attitude.

    Args:
        gains: a `TorqueLeak`.
        inputs: of this tick.
        thrusts: of this tick.
    """
    estimate = inputs.estimate
    rotation = thrusts.rotation
    if gains.steady:
        holding = -estimate.wrench.torque - estimate.bias.torque
        rotation = right_inverse(estimate.body.model.allocation_C[2:, :]) @ stack(0.0, holding)
    return rotor_wrench(estimate.body, rotation).force


def follow_leak(gains: Any, leak: Array, now: Array, dt: float) -> Array:
    """The leak behind its low pass, W, N, (3,), from that of the last tick and the one of this tick."""
    return low_pass(leak, now, 2.0 * math.pi * gains.cutoff, dt)
