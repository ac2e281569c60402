"""The way down: straight, never far below the robot, and back from a surface first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skylimb.control.missions.reference import Reference
from skylimb.flight.realtime.retreat import BACK, BACK_SPEED, Retreat

LEAD = 0.5
"""How far the target may be below a robot that does not sink, m: it stands, and the thrusts go down."""


@dataclass(frozen=True)
class Landing:
    """A landing that began at some reference.

    Attributes:
        last: reference at which it began.
        begin: when, s.
        back: whether to leave a surface first.
        speed: down, m/s.
    """

    last: Reference
    begin: float
    back: bool
    speed: float

    def at(self, now: float, height: float) -> Reference:
        """The reference of now.

        Args:
            now: s.
            height: of the centre of gravity as measured, m.
        """
        since = now - self.begin
        lowest = height - LEAD
        if self.back:
            away = BACK / BACK_SPEED
            if since < away:
                return Retreat(self.last).at(since)
            start, since = Retreat(self.last).at(away), since - away
        else:
            start = self.last._replace(tare=0.0, adapt=0.0, touch=0.0, wait=0.0, ahead=())
        position = np.array(start.position, dtype=float)
        down = min(self.speed * since, max(0.0, position[2] - lowest))
        moved = np.array([0.0, 0.0, -down])
        velocity = np.array([0.0, 0.0, -self.speed])
        return start._replace(
            position=position + moved,
            velocity=velocity,
            acceleration=np.zeros(3),
            tip_position=np.asarray(start.tip_position) + moved,
            tip_velocity=velocity,
            tip_acceleration=np.zeros(3),
        )
