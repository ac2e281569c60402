"""What a tick of the pilot takes, and what it comes to."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from skylimb.analysis.exchange.body import Body
from skylimb.analysis.exchange.lab_ticks import Names, TickView
from skylimb.analysis.exchange.messages import Joints, Nav, Path, Pose, Pwms
from skylimb.apps.ros.script import Script
from skylimb.apps.ros.states import FlightState, Flying, Order
from skylimb.control.estimation.records import Measurement, Taken
from skylimb.control.missions.reference import Reference
from skylimb.control.records import Command

STARTED_BY_ITS_USER = "a flight over ROS, whose take-off its user chooses,"
"""Who applies no events: their times count from take-off."""

Request = Pose | Path | Nav | Joints
"""A target that a user asks for."""


@dataclass(frozen=True)
class Received:
    """What came since the last tick.

    Attributes:
        orders: of a user, in their order.
        requests: of a user, in their order.
        mission: that is to be flown; None where none was asked for.
        acknowledged: the last command that the flight controller acknowledged since then.
        battery: charge, per cent; NaN where its voltage is none.
        volts: its voltage; None where it said nothing, or none.
        pwms: what the motors are driven with; None where the flight controller said nothing.
        carried: share of the robot's weight that this gives at most; infinity where nobody knows.
        radio: when a radio was heard, s; None where none was.
        taken_over: whether its sticks are moved.
        foreign: who else commands the robot; None where nobody has looked since.
    """

    orders: tuple[Order, ...] = ()
    requests: tuple[Request, ...] = ()
    mission: str | None = None
    acknowledged: int | None = None
    battery: float | None = None
    volts: float | None = None
    pwms: Pwms | None = None
    carried: float = math.inf
    radio: float | None = None
    taken_over: bool = False
    foreign: tuple[str, ...] | None = None

    @property
    def armed(self) -> bool | None:
        """Whether the flight controller says that it is armed; None where it said nothing."""
        return None if self.pwms is None else self.pwms.armed


@dataclass(frozen=True)
class Inputs:
    """What a tick is made of.

    Attributes:
        now: the pacer's time, s.
        measurement: the newest one; None while there has been none.
        taken: when its parts were measured, s.
        received: since the last tick.
        ages: of the newest message of each sensor, s.
        offsets: of the sensors' clocks from ours, s.
        rate: of the motion capture, Hz; NaN before its second frame.
        rest: for how long the accelerometer has felt its weight and nothing else, s.
        stamp_offset: what has to be added to a request's stamp for our clock, s.
        lost: why the robot has to be led back though it is seen; empty while nothing is.
        missing: topics without which there is no measurement, and on which nothing has come that is one.
    """

    now: float
    measurement: Measurement | None
    taken: Taken
    received: Received = field(default_factory=Received)
    stamp_offset: float = 0.0
    ages: Mapping[str, float] = field(default_factory=dict)
    offsets: Mapping[str, float] = field(default_factory=dict)
    rest: float = 0.0
    lost: str = ""
    rate: float = math.nan
    missing: tuple[str, ...] = ()


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
        yaw: of the lab's link that the reference means, rad.
        scale: of the thrusts that the rotors are commanded, over those of the controller.
    """

    flying: Flying
    command: Command
    motors: bool
    reference: Reference | None
    signals: Mapping[str, Any]
    script: Script | None
    body: Body | None
    said: tuple[str, ...]
    yaw: float = 0.0
    scale: float = 1.0

    @property
    def driven(self) -> Command:
        """What is commanded of the actuators."""
        return self.command._replace(thrusts=self.scale * self.command.thrusts)

    def view(self, stamp: float, names: Names, measured: Measurement | None) -> TickView:
        """What messages are made of."""
        reference = self.reference
        return TickView(
            stamp,
            names,
            self.body,
            None if measured is None else np.concatenate(measured[4:6]),
            tuple(self.driven),
            # A board that does not hear that it is disarmed hears that it is to thrust no more.
            self.motors or self.flying.state == FlightState.STOP,
            self.signals,
            magnetic_field=(0.0, 0.0, 0.0),
            state=self.flying.shown,
            arming=self.flying.arming,
            target=None if reference is None else (reference.position, reference.velocity, self.yaw),
        )
