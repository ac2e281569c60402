"""What a tick of the pilot takes, and what it comes to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from skylimb.apps.ros1.body import Body
from skylimb.apps.ros1.script import Script
from skylimb.apps.ros1.states import Flying, Order
from skylimb.apps.ros1.wishes import Wish
from skylimb.control.estimation.records import Measurement
from skylimb.control.missions.reference import Reference
from skylimb.control.records import Command

STARTED_BY_ITS_USER = "a flight over ROS, whose take-off its user chooses,"
"""Who applies no events: their times count from take-off."""


@dataclass(frozen=True)
class Inputs:
    """What came since the last tick.

    Attributes:
        now: the pacer's time, s.
        measurement: the newest one; None while there has been none.
        taken: when it was measured, s.
        orders: of a user, in their order.
        wishes: of a user, in their order, each with what is to be added to its stamp for our clock, s.
        mission: that is to be flown; empty for none.
        acknowledged: the last command that the flight controller acknowledged since then.
        battery: charge, per cent.
    """

    now: float
    measurement: Measurement | None
    taken: float
    orders: tuple[Order, ...] = ()
    wishes: tuple[tuple[Wish, float], ...] = ()
    mission: str = ""
    acknowledged: int | None = None
    battery: float | None = None


@dataclass(frozen=True)
class Tick:
    """What a tick came to.

    Attributes:
        flying: the flight's state.
        command: to the actuators; thrusts are zero where the motors are off.
        motors: whether the thrusts mean anything.
        reference: that the controller was given; None where none flew.
        signals: the controller's own; empty where none flew.
        script: the mission under way as this tick flew it; None without one.
        body: centre of gravity and the lab's link as measured; None where nothing fresh is.
        said: to people, one line each.
    """

    flying: Flying
    command: Command
    motors: bool
    reference: Reference | None
    signals: Mapping[str, Any]
    script: Script | None
    body: Body | None
    said: tuple[str, ...]
