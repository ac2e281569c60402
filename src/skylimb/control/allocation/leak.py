"""The side force of the rotational thrusts, and its compensation.

eq:thrust rotation 1 and the sentence before it take lambda_r to be a pure torque. With tilted rotors
Q_t pinv(Q_r) is not zero: for hydrus_xi_quad at theta = pi/6 with the heading along x, a newton metre of
yaw torque pushes with about (1.1, 0.7, -0.5) N in W. On one sign of the board's slope the contact's yaw
torque then unloads the pen, on the other it feeds back positively. Taking the low-passed leak off the wanted
force before the attitude target is formed cures it. Off in the paper's presets.
"""

from __future__ import annotations

import math
from typing import Annotated, Any

from skylimb.base.keys import Key, configuration
from skylimb.control.allocation.thrusts import Thrusts
from skylimb.control.estimation.body_state import rotor_wrench
from skylimb.control.records import NOTHING, LawInput
from skylimb.symbolic import Array, low_pass, right_inverse, stack


@configuration
class Leak:
    """Whether the leak is compensated, and how fast."""

    compensate: Annotated[bool, Key("", "whether the leak is taken off; off in the paper's presets")] = False
    cutoff: Annotated[
        float,
        Key(
            "Hz",
            "cut-off of the low pass on the leak; below the attitude loop's own bandwidth",
            above=0.0,
            high=100.0,
        ),
    ] = 0.5


@configuration
class TorqueLeak(Leak):
    """The leak of the rotational thrusts alone.

    The torque that holds the attitude against the estimated disturbance is free of the attitude loop's own
    motion, so that its leak may be followed faster than that of the commanded torque.
    """

    steady: Annotated[
        bool, Key("", "whether it is the leak of the torque that holds, not of the commanded one")
    ] = False


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
        holding = -estimate.wrench.torque - (estimate.bias or NOTHING).torque
        rotation = right_inverse(estimate.body.model.allocation_C[2:, :]) @ stack(0.0, holding)
    return rotor_wrench(estimate.body, rotation).force


def follow_leak(gains: Any, leak: Array, now: Array, dt: float) -> Array:
    """The leak behind its low pass, W, N, (3,), from that of the last tick and the one of this tick."""
    return low_pass(leak, now, 2.0 * math.pi * gains.cutoff, dt)
