"""When a robot that is led down stands, and when one behind a link has landed.

Before that no command may stop. Whoever lands a robot, behind a link or on ROS, asks `Standing`. What differs
is what is done until then: behind a link nothing but commands reaches the robot, so it is led ever deeper; on
ROS a node scales what is commanded of its rotors, and has a flight controller that brings it down blind
(`apps/ros/transitions.py`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from skylimb.control.supervisor.retreat import retreat_time

DEPTH = 3.0
"""How far below its floor a landing leads, m: a robot with 10 % too much thrust stays half a metre above
where it is led, and the thrusts of one that stands go down only as it is led deeper."""

LOW = 0.7
"""Share of the hover thrusts that no robot flies with, also one whose rotors give a quarter more: one that
does not sink with less of them stands."""

STANDS, WAY = 0.5, 0.02
"""Time for which it has to stand, s, and the way that its height may change by in that, m: the lab's own."""

LONGER = 5.0
"""Seconds after which the commands stop in any case, when it was led to the deepest: where nobody sees it."""


class Standing(NamedTuple):
    """Since when a robot stands: commanded too little to fly with, and as high as it was.

    Attributes:
        height: of its centre of gravity, m; NaN where nobody sees it.
        since: when it was there first, s.
    """

    height: float = np.nan
    since: float = np.inf

    def after(self, height: float | None, light: bool, now: float) -> Standing:
        """A tick later.

        Args:
            height: of the centre of gravity, m; None where nobody sees it.
            light: whether less is commanded of the rotors than any robot flies with.
            now: s.
        """
        if height is None:
            return Standing()
        return self if light and abs(height - self.height) < WAY else Standing(height, now)

    def stands(self, now: float) -> bool:
        """Whether it has been there for long enough; rounding may hold it up no tick longer."""
        return now - self.since > STANDS - 1e-9


class Landing(NamedTuple):
    """A landing so far.

    Attributes:
        floor: height of the centre of gravity at which a robot that is seen there has come down, m.
        deepest: time after which its reference is as deep as it goes, s.
        shortest: time in which its reference comes to the floor, s.
        time: since it began, s.
        standing: since when it has not sunk with low thrusts.
    """

    floor: float
    deepest: float
    shortest: float
    time: float = 0.0
    standing: Standing = Standing()

    @property
    def longest(self) -> float:
        """The time that it may take, s."""
        return self.deepest + LONGER

    @property
    def over(self) -> bool:
        """Whether the robot is down: at its floor, or standing above it; or nobody will ever know."""
        down = self.standing.height <= self.floor or self.standing.stands(self.time)
        return (down and self.time >= self.shortest) or self.time >= self.longest

    def after(self, height: float | None, share: float, dt: float) -> Landing:
        """A tick later.

        Args:
            height: of the centre of gravity, m; None where nobody sees it.
            share: of the hover thrusts that is commanded.
            dt: control period, s.
        """
        time = self.time + dt
        return self._replace(time=time, standing=self.standing.after(height, share < LOW, time))


def landing_from(height: float, floor: float) -> Landing:
    """A landing that begins.

    Args:
        height: of the reference where it begins, m.
        floor: see `Landing`.
    """
    return Landing(floor, retreat_time(height - floor + DEPTH), retreat_time(height - floor))
