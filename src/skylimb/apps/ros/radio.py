"""A radio beside the computer: whoever holds it lands, stops and steers, and its silence lands the robot.

Which buttons and axes mean what says a `Pad`. A stick that is moved ends a mission. A radio that was heard
once has to be heard on: it sends also while nobody touches it.
"""

from __future__ import annotations

import math

from skylimb.analysis.exchange.messages import Joy, Nav, NavMode
from skylimb.apps.ros.limits import FlightLimits
from skylimb.apps.ros.pad import Pad
from skylimb.apps.ros.states import Order

DEAD = 0.2
"""Of an axis: nobody means so little."""


def ordered(before: Joy | None, now: Joy, pad: Pad) -> list[Order]:
    """What the buttons order that were not held before."""
    held = before.buttons if before is not None else ()
    return [
        order
        for number, order in ((pad.land, Order.LAND), (pad.halt, Order.HALT))
        if any(now.buttons[number : number + 1]) and not any(held[number : number + 1])
    ]


def steered(joy: Joy, limits: FlightLimits) -> Nav | None:
    """The velocity that the sticks ask for; None while they rest."""
    pad = limits.pad
    pushed = (sum(joy.axes[number : number + 1]) for number in (pad.forward, pad.left, pad.up, pad.yaw))
    # What is no number asks for nothing: nobody pushes a stick that far.
    x, y, z, turn = (axis if math.isfinite(axis) and abs(axis) > DEAD else 0.0 for axis in pushed)
    if not any((x, y, z, turn)):
        return None
    velocity = (limits.fastest * x, limits.fastest * y, limits.fastest * z)
    by = int(NavMode.VELOCITY)
    return Nav(by, by, by, (0.0, 0.0, 0.0), velocity, 0.0, limits.turn_speed * turn, frame=1)
