"""Where the tip is led along the contact axis out of touch: with the mission, to the surface, or back.

A surface that nobody has touched is looked for at `approach_speed`, which the peak of the touch goes with.
One that the pen has drawn on is known: between two strokes the tip goes to it at `return_speed`, and slows
down for it where it may be near.
"""

from __future__ import annotations

from typing import Any

from skylimb.control.contact_machine import APPROACH, FREE, RECONTACT, RETREAT, MachineState, is_in
from skylimb.control.records import LawInput
from skylimb.symbolic import clip, dot, max, where

NEAR, SURE = 0.045, 2.0
"""A known surface is near from so far on, m, and so many standard deviations more."""

BRAKES = 1.2
"""Time constant in which the tip slows down for it, s."""


def led(
    gains: Any, machine: MachineState, place: Any, nominal: Any, known: Any, height: Any, inputs: LawInput
) -> tuple[Any, Any]:
    """Place (m) and speed (m/s) of the tip along the contact axis, of this tick.

    Args:
        gains: of the contact law.
        machine: of the contact, at this tick.
        place: at which the tip was wanted along the axis, m.
        nominal: at which the mission has it, m.
        known: 1 where the surface is known.
        height: where it is expected, and its standard deviation, m.
        inputs: of the law.
    """
    reference, dt = inputs.reference, inputs.dt
    searching, free = is_in(machine.state, APPROACH, RECONTACT), is_in(machine.state, FREE)
    back = clip(nominal - place, -gains.retreat_speed * dt, gains.retreat_speed * dt) / dt
    far = height[0] - place - NEAR - SURE * height[1]
    faster = clip(far / BRAKES, 0.0, max(gains.return_speed - gains.approach_speed, 0.0))
    speed = gains.approach_speed + known * is_in(machine.state, APPROACH) * faster
    gathering = clip(machine.since / gains.approach_ramp, 0.0, 1.0)
    velocity = searching * speed * gathering + is_in(machine.state, RETREAT) * back
    position = where(free > 0.5, nominal, place + velocity * dt)
    return position, velocity + free * dot(reference.contact_axis, reference.tip_velocity)
