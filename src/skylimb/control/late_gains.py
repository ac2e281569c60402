"""The gains of a controller whose measurements come later than it was tuned for.

Three sets: its own, while they are in time; its own with the latency that is seen, as long as that holds the
attitude; and a soft attitude beside it for those that come later still, with which it flies back.
"""

from __future__ import annotations

from typing import Any

from skylimb.base.packing import Layout
from skylimb.symbolic import Array, stack, where

LATENCY, STIFFNESS = "estimation.delay.latency", "attitude.normalized_stiffness"
"""Gains that change, where a controller has them."""

MOST, SOFT = 0.06, 0.25
"""Lateness that the attitude's own stiffness bears, s, and the share of it that bears more."""


def late_gains(layout: Layout[Any], gains: Array, late: Any) -> Array:
    """Flat gains, in numbers or symbols.

    Args:
        layout: of the gains.
        gains: the controller's own.
        late: how much later than assumed measurements are, s; 0 leaves every bit as it is.
    """
    if not layout.size:
        return gains
    changes = {
        name: gains[place] + late if name == LATENCY else gains[place] * where(late > MOST, SOFT, 1.0)
        for name, place in layout.slices.items()
        if name in (LATENCY, STIFFNESS)
    }
    return stack(*(changes.get(name, gains[place]) for name, place in layout.slices.items()))
