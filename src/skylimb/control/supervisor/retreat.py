"""Away from the surface and down: the reference of a flight that is broken off."""

from __future__ import annotations

from typing import Any

from skylimb.control.missions.reference import Reference
from skylimb.symbolic import max, min, vector, where

BACK, BACK_SPEED = 0.3, 0.2
"""Way back along the contact axis, m, and its speed, m/s."""

DESCENT = 0.3
"""Speed down, m/s: that of the lab's own landing."""


def retreat(last: Reference, time: Any, floor: Any = 0.0, back: float = BACK) -> Reference:
    """Back along the contact axis, then straight down, in the posture that the robot has.

    Args:
        last: the reference at which the flight was broken off.
        time: since then, s.
        floor: height of the centre of gravity at which the descent ends, m.
        back: way back, m; 0 where the robot touches nothing.
    """
    gone = min(BACK_SPEED * time, back)
    height = last.position[2]
    down = max(0.0, time - back / BACK_SPEED) * DESCENT
    lowest = min(height, floor)
    moved = -gone * last.contact_axis + vector(0.0, 0.0, max(height - down, lowest) - height)
    sinking = where(height - down > lowest, -DESCENT, 0.0)
    velocity = where(gone < back, -BACK_SPEED * last.contact_axis, vector(0.0, 0.0, sinking))
    still = 0.0 * moved
    return last._replace(
        position=last.position + moved,
        velocity=velocity,
        acceleration=still,
        tip_position=last.tip_position + moved,
        tip_velocity=velocity,
        tip_acceleration=still,
        tare=0.0,
        adapt=0.0,
        touch=0.0,
        wait=0.0,
        ahead=(),
    )
