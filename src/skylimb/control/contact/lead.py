"""Where the tip is led along the contact axis out of touch: with the mission, to the surface, or back.

A lifted pen need not go out as far as the mission says, which knows the surface's nominal place alone: over a
surface that it has drawn on, as far as the mission's clearance above where that surface is expected. Where
it recedes, it may not go on to.

A surface that nobody has touched is looked for at `approach_speed`, which the peak of the touch goes with.
One that the pen has drawn on is known: between two strokes the tip goes to it at `return_speed`, and slows
down for it where it may be near.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from skylimb.control.contact.machine import APPROACH, CLEAR, FREE, RECONTACT, RETREAT, MachineState, is_in
from skylimb.control.records import LawInput, Reference
from skylimb.symbolic import abs, clip, dot, max, min, where

NEAR, SURE = 0.045, 2.0
"""A known surface is near from so far on, m, and so many standard deviations more."""

LEFT, DRIFTS = 0.005, 0.3
"""So far off a free tip has been left by its mission, m; time constant of its way there, s."""

BRAKES = 1.2
"""Time constant in which the tip slows down for it, s."""


def is_lifted(reference: Reference, known: Any) -> Any:
    """1 while the pen is lifted over a surface that it knows (`known` is 1), else 0."""
    return known * where(reference.clearance > 0.0, 1.0, 0.0)


def wanted_out(reference: Reference, nominal: Any, known: Any, heights: Sequence[tuple[Any, Any]]) -> Any:
    """Where along the contact axis the tip is wanted out of touch, m.

    Args:
        reference: of this tick.
        nominal: at which the mission has it, m.
        known: 1 where the surface is known.
        heights: where that is expected where the pen left it, and below it now and soon, and its standard
            deviation, m.
    """
    near = heights[0][0] - SURE * heights[0][1]
    for height, deviation in heights[1:]:
        near = min(near, height - SURE * deviation)
    return where(is_lifted(reference, known) > 0.5, max(nominal, near - reference.clearance), nominal)


def led(
    gains: Any, machine: MachineState, place: Any, out: Any, known: Any, height: Any, inputs: LawInput
) -> tuple[Any, Any]:
    """Place (m) and speed (m/s) of the tip along the contact axis, of this tick.

    Args:
        gains: of the contact law.
        machine: of the contact, at this tick.
        place: at which the tip was wanted along the axis, m.
        out: at which it is wanted out of touch, m.
        known: 1 where the surface is known.
        height: where it is expected, and its standard deviation, m.
        inputs: of the law.
    """
    reference, dt = inputs.reference, inputs.dt
    lifted = is_lifted(reference, known)
    searching, free = is_in(machine.state, APPROACH, RECONTACT), is_in(machine.state, FREE)
    back = clip(out - place, -gains.retreat_speed * dt, gains.retreat_speed * dt) / dt
    far = height[0] - place - NEAR - SURE * height[1]
    faster = clip(far / BRAKES, 0.0, max(gains.return_speed - gains.approach_speed, 0.0))
    speed = gains.approach_speed + known * is_in(machine.state, APPROACH) * faster
    gathering = clip(machine.since / gains.approach_ramp, 0.0, 1.0)
    # Free, the tip goes exactly with the mission; softly where that has left it, or where the surface, which
    # is estimated, says how far out it goes.
    left = is_in(machine.reason, CLEAR) * where(abs(out - place) > LEFT, 1.0, 0.0)
    softly = free * max(lifted, left)
    exactly = free - softly
    drift = clip((out - place) / DRIFTS, -gains.retreat_speed, gains.retreat_speed)
    velocity = searching * speed * gathering + is_in(machine.state, RETREAT) * back + softly * drift
    position = where(exactly > 0.5, out, place + velocity * dt)
    return position, velocity + exactly * dot(reference.contact_axis, reference.tip_velocity)
