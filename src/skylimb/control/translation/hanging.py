"""How a tilt moves a pen that hangs below the centre of gravity, and how much of that is followed at once.

A robot that tilts to go aside moves such a pen the other way first: seen at the pen, its dynamics

    p / f = (g - h s^2) / (m g s^2),        h the height of the centre of gravity over the pen,

have a zero at sqrt(g / h) in the right half plane, 4.4 rad/s for half a metre. A spring at the pen of
3 rad/s then sways. So the spring is at the pen of the level robot, and makes up slowly for what a tilt that
lasts, as against friction, moves it. A damper that counts the pen's swing leaves out that of what hangs, for
the same reason. Ahead of the body, or above it, a pen has no such zero.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from skylimb.control.estimation.records import Estimate
from skylimb.symbolic import Array, clip, dot, low_pass, vector

HANGS = (0.15, 0.3)
"""Depths below the centre of gravity from which on a pen begins to hang, and does, m."""

SLOWLY = 1.0
"""Rate at which a tilt is made up for, 1/s; far below the zero of any robot's arm."""

FIRMER = 0.6
"""By how much of itself the sliding axes' damping grows: a pen that rubs turns the body about itself."""


class Hanging(NamedTuple):
    """What springs and dampers across the contact axis go by; of a pen that does not hang, the arm as it is.

    Attributes:
        arm: that a spring follows, W, m, (3,).
        swings: what of the arm a damper may count the swing of, W, m, (3,).
        firmness: the factor of the damping.
        slow: low-passed way by which a tilt moves the pen, to be kept for the next tick, W, m, (3,).
    """

    arm: Array
    swings: Array
    firmness: Any
    slow: Array


def slow_arm(estimate: Estimate, share: Any, before: Array, dt: float) -> Hanging:
    """How a pen is followed that may hang.

    Args:
        estimate: of this tick.
        share: of the way by which a tilt moves the pen that is followed slowly.
        before: that way, low-passed, of the last tick, W, m, (3,).
        dt: control period, s.
    """
    level = vector(0.0, 0.0, 1.0)
    up = estimate.body.R_WC @ level
    depth = -dot(up, estimate.arm)
    hangs = clip((depth - HANGS[0]) / (HANGS[1] - HANGS[0]), 0.0, 1.0) * share
    moved = depth * (level - up)
    slow = low_pass(before, moved, SLOWLY, dt)
    return Hanging(
        estimate.arm - hangs * (moved - slow),
        estimate.arm + hangs * depth * up,
        1.0 + FIRMER * hangs,
        slow,
    )
