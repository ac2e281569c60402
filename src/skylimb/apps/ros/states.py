"""The lab's flight states: what a robot is doing, what is looked at, and what is remembered.

How one follows another is in `transitions`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import IntEnum, StrEnum

import numpy as np

from skylimb.analysis.exchange.lab_topics import ORDERS
from skylimb.flight.realtime.charge import Charge
from skylimb.flight.realtime.landing import Standing


class FlightState(IntEnum):
    """As on the topic `flight_state`."""

    ARM_OFF = 0
    START = 1
    ARM_ON = 2
    TAKEOFF = 3
    LAND = 4
    HOVER = 5
    STOP = 6


LOW_BATTERY, FORCE_LANDING = 0x10, 0x11
"""Take the place of the state on that topic."""

UNKNOWN_HEIGHT = 2.0
"""That a robot is believed to fly at where nobody knows the ground, m."""

FLYING = (FlightState.TAKEOFF, FlightState.HOVER, FlightState.LAND)


class Order(StrEnum):
    """What a user orders, by the last word of its topic."""

    START = "start"
    TAKEOFF = "takeoff"
    LAND = "land"
    HALT = "halt"
    FORCE_LANDING = "force_landing"


ORDERED = {topic.name: Order(topic.name.rpartition("/")[2]) for topic in ORDERS}
"""What a message on each of these topics orders."""


class Arming(IntEnum):
    """What the flight controller is commanded, and acknowledges."""

    ON = 0
    OFF = 1
    FORCE_LANDING = 2


@dataclass(frozen=True)
class Seen:
    """What the flight states look at in a tick.

    Attributes:
        now: s.
        position: of the centre of gravity in W, m, (3,); None while nothing fresh is measured.
        sinking: its speed down, m/s.
        target: of that position, m, (3,); None while it is not led down.
        orders: that came since the last tick, in their order.
        acknowledged: the last command that the flight controller acknowledged since then; None without one.
        battery: charge, per cent; None where nobody says.
        broken: why the flight has to be broken off; empty while it has not.
        refused: why a flight must not begin; nothing where it may.
        armed: whether the flight controller says that it is armed; None where it has said nothing since.
        carried: share of its weight that its motors give at most; infinity where nobody knows.
        rest: for how long the accelerometer has felt its weight and nothing else, s.
        cut: whether the supervisor has cut the rotors.
        light: whether less is commanded of the rotors than any robot flies with.
        foreign: who else commands the robot, "node on topic".
    """

    now: float
    position: np.ndarray | None
    sinking: float = 0.0
    target: np.ndarray | None = None
    orders: tuple[Order, ...] = ()
    acknowledged: int | None = None
    battery: float | None = None
    broken: str = ""
    refused: tuple[str, ...] = ()
    armed: bool | None = None
    carried: float = math.inf
    rest: float = 0.0
    cut: bool = False
    light: bool = False
    foreign: tuple[str, ...] = ()


@dataclass(frozen=True)
class Flying:
    """The state, and what its transitions remember.

    Attributes:
        state: of the flight.
        since: when it began, s.
        origin: position at `start`, m, (3,).
        settled: since when a take-off has been near its target, s.
        standing: since when a robot that is led down, or was found armed, stands.
        eases: whether a landing that does not sink takes thrust away.
        light: since when less has been commanded of the rotors than any robot flies with, s.
        blind: since when the position is not known, s.
        above: the height above the origin at which it was known last, m.
        force_landing: whether the landing is a forced one.
        charge: whether the battery is nearly empty.
        left: whether an armed robot is left to somebody else, who commands it.
    """

    state: FlightState = FlightState.ARM_OFF
    since: float = 0.0
    origin: np.ndarray | None = None
    settled: float = math.inf
    standing: Standing = field(default_factory=Standing)
    eases: bool = False
    light: float = math.inf
    blind: float = math.nan
    above: float = UNKNOWN_HEIGHT
    force_landing: bool = False
    charge: Charge = field(default_factory=Charge)
    left: bool = False

    @property
    def low_battery(self) -> bool:
        """Whether the battery is nearly empty, and has been so for some seconds."""
        return self.charge.low

    @property
    def shown(self) -> int:
        """The byte on the topic `flight_state`."""
        if self.force_landing:
            return FORCE_LANDING
        return LOW_BATTERY if self.low_battery else int(self.state)

    @property
    def in_air(self) -> bool:
        """Whether a controller flies the robot."""
        return self.state in FLYING

    @property
    def arming(self) -> Arming | None:
        """What the flight controller is commanded at this tick."""
        if self.force_landing and self.in_air:
            return Arming.FORCE_LANDING
        return {FlightState.START: Arming.ON, FlightState.STOP: Arming.OFF}.get(self.state)
