"""The gains of a controller whose measurements come later than it was tuned for, or whose rotors are slower.

Sets that differ in little: its own, while they are in time; its own with the latency that is seen; with an
attitude half as stiff, where that is much; and with a softer one still where it is more than a mission can be
flown with, to fly back. Of rotors that are slower their lag is believed.
"""

from __future__ import annotations

from typing import Any

from skylimb.base.packing import Layout
from skylimb.symbolic import Array, stack, where

LATENCY, LAG = "estimation.delay.latency", "allocation.rotor_lag.time_constant"
STIFFNESS = "attitude.normalized_stiffness"
"""Gains that change, where a controller has them."""

SOME, SOFTER = 0.04, 0.5
"""Lateness that the attitude's own stiffness bears, s, and the share of it that bears more."""

MOST, SOFT = 0.06, 0.25
"""Lateness with which a mission can be flown, s, and the share of the stiffness that flies back with more."""


def late_gains(layout: Layout[Any], gains: Array, late: Any, slow: Any) -> Array:
    """Flat gains, in numbers or symbols.

    Args:
        layout: of the gains.
        gains: the controller's own.
        late: how much later than assumed measurements are, s; 0 leaves every bit as it is.
        slow: by how much more than assumed the rotors lag, s; likewise.
    """
    if not layout.size:
        return gains
    changed = {
        LATENCY: lambda own: own + late,
        LAG: lambda own: own + slow,
        STIFFNESS: lambda own: own * where(late > MOST, SOFT, where(late > SOME, SOFTER, 1.0)),
    }
    parts = [(changed.get(name), gains[place]) for name, place in layout.slices.items()]
    return stack(*(own if change is None else change(own) for change, own in parts))
