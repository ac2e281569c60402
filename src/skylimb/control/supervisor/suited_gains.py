"""The gains of a controller whose measurements come late or were away, or whose rotors are slow.

Sets that differ in little: its own, while they are in time; its own with the latency that is seen; with an
attitude half as stiff, where that is much; and with a softer one still where it is more than a mission can be
flown with, to fly back. Of rotors that are slower their lag is believed. A pen that has drifted ahead of its
path while no pose was seen is not held by friction: for a while it presses on.
"""

from __future__ import annotations

from typing import Any

from skylimb.base.packing import Layout
from skylimb.symbolic import Array, stack, where

LATENCY, LAG = "estimation.delay.latency", "allocation.rotor_lag.time_constant"
STIFFNESS, EASE = "attitude.normalized_stiffness", "contact.ease_ahead"
"""Gains that change, where a controller has them."""

SOME, SOFTER = 0.04, 0.5
"""Lateness that the attitude's own stiffness bears, s, and the share of it that bears more."""

MOST, SOFT = 0.06, 0.25
"""Lateness with which a mission can be flown, s, and the share of the stiffness that flies back with more."""

RETURNED = 2.0
"""Time for which poses have just come back, s."""


def suited_gains(layout: Layout[Any], gains: Array, late: Any, slow: Any, back: Any) -> Array:
    """Flat gains, in numbers or symbols.

    Args:
        layout: of the gains.
        gains: the controller's own.
        late: how much later than assumed measurements are, s; 0 leaves every bit as it is.
        slow: by how much more than assumed the rotors lag, s; likewise.
        back: since the pose was the model's, s; 0 while it is, and from `RETURNED` on likewise.
    """
    if not layout.size:
        return gains
    just_back = where(back > 0.0, where(back < RETURNED, 1.0, 0.0), 0.0)
    changed = {
        LATENCY: lambda own: own + late,
        LAG: lambda own: own + slow,
        EASE: lambda own: own * (1.0 - just_back),
        STIFFNESS: lambda own: own * where(late > MOST, SOFT, where(late > SOME, SOFTER, 1.0)),
    }
    parts = [(changed.get(name), gains[place]) for name, place in layout.slices.items()]
    return stack(*(own if change is None else change(own) for change, own in parts))
