"""When a robot behind a link has landed: before that no command may stop."""

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


class Landing(NamedTuple):
    """A landing so far.

    Attributes:
        floor: height of the centre of gravity at which a robot that is seen there has come down, m.
        deepest: time after which its reference is as deep as it goes, s.
        shortest: time in which its reference comes to the floor, s.
        time: since it began, s.
        stands: for how long it has not sunk with low thrusts, s.
        height: of the centre of gravity since then, m.
    """

    floor: float
    deepest: float
    shortest: float
    time: float = 0.0
    stands: float = 0.0
    height: float = np.nan

    @property
    def longest(self) -> float:
        """The time that it may take, s."""
        return self.deepest + LONGER

    @property
    def over(self) -> bool:
        """Whether the robot is down: at its floor, or standing above it; or nobody will ever know."""
        down = self.height <= self.floor or self.stands >= STANDS
        return (down and self.time >= self.shortest) or self.time >= self.longest

    def after(self, height: float | None, share: float, dt: float) -> Landing:
        """A tick later.

        Args:
            height: of the centre of gravity, m; None where nobody sees it.
            share: of the hover thrusts that is commanded.
            dt: control period, s.
        """
        time = self.time + dt
        if height is None:
            return self._replace(time=time, stands=0.0, height=np.nan)
        if share < LOW and abs(height - self.height) < WAY:
            return self._replace(time=time, stands=self.stands + dt)
        return self._replace(time=time, stands=0.0, height=height)


def landing_from(height: float, floor: float) -> Landing:
    """A landing that begins.

    Args:
        height: of the reference where it begins, m.
        floor: see `Landing`.
    """
    return Landing(floor, retreat_time(height - floor + DEPTH), retreat_time(height - floor))
