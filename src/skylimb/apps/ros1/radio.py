"""A radio beside the computer: whoever holds it lands, stops and steers, and its silence lands the robot.

The numbers are those of ROS's `joy_node` for a pad with two sticks: the left one is height and heading, the
right one forward and sideways; button A lands, B stops the motors. A stick that is moved ends a mission. A
radio that was heard once has to be heard on: it sends also while nobody touches it.
"""

from __future__ import annotations

from skylimb.analysis.exchange.messages import Joy, Nav, NavMode
from skylimb.apps.ros1.limits import FlightLimits
from skylimb.apps.ros1.states import Order

BUTTONS = {0: Order.LAND, 1: Order.HALT}
"""What they order, by their numbers."""

YAW, UP, LEFT, FORWARD = 0, 1, 3, 4
"""Numbers of the axes, -1 .. 1; left and up are positive."""

DEAD = 0.2
"""Of an axis: nobody means so little."""


def ordered(before: Joy | None, now: Joy) -> list[Order]:
    """What the buttons order that were not held before."""
    held = before.buttons if before is not None else ()
    return [
        order
        for number, order in BUTTONS.items()
        if any(now.buttons[number : number + 1]) and not any(held[number : number + 1])
    ]


def steered(joy: Joy, limits: FlightLimits) -> Nav | None:
    """The velocity that the sticks ask for; None while they rest."""
    axes = [*joy.axes, 0.0, 0.0, 0.0, 0.0, 0.0]
    x, y, z, turn = (axes[number] * (abs(axes[number]) > DEAD) for number in (FORWARD, LEFT, UP, YAW))
    if not any((x, y, z, turn)):
        return None
    velocity = (limits.fastest * x, limits.fastest * y, limits.fastest * z)
    by = int(NavMode.VELOCITY)
    return Nav(by, by, by, (0.0, 0.0, 0.0), velocity, 0.0, limits.turn_speed * turn, frame=1)
