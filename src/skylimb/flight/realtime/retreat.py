"""Away from the surface and down: the references of a flight that is broken off."""

from __future__ import annotations

import numpy as np

from skylimb.control.missions.reference import Reference

BACK, BACK_SPEED = 0.3, 0.2
"""Way back along the contact axis, m, and its speed, m/s."""

DESCENT = 0.3
"""Speed down, m/s: that of the lab's own landing."""


class Retreat:
    """Back along the contact axis, then straight down, in the posture that the robot has.

    Args:
        last: the reference at which the flight was broken off.
        floor: height of the centre of gravity at which the descent ends, m.
        back: whether it goes back first, as the robot may touch a surface.

    Attributes:
        last: the same.
        floor: the same; it may change on the way.
    """

    def __init__(self, last: Reference, floor: float = 0.0, back: bool = True) -> None:
        self.last, self.floor, self._back = last, floor, BACK if back else 0.0
        self._position = np.array(last.position, dtype=float)
        self._axis = np.array(last.contact_axis, dtype=float)

    def at(self, time: float) -> Reference:
        """The reference some seconds after the flight was broken off."""
        back = min(BACK_SPEED * time, self._back)
        down = max(0.0, time - self._back / BACK_SPEED) * DESCENT
        position = self._position - back * self._axis
        height = max(position[2] - down, min(position[2], self.floor))
        velocity = np.zeros(3)
        if back < self._back:
            velocity = -BACK_SPEED * self._axis
        elif height > self.floor:
            velocity = np.array([0.0, 0.0, -DESCENT])
        position = np.array([position[0], position[1], height])
        moved = position - self._position
        return self.last._replace(
            position=position,
            velocity=velocity,
            acceleration=np.zeros(3),
            tip_position=np.asarray(self.last.tip_position) + moved,
            tip_velocity=velocity,
            tip_acceleration=np.zeros(3),
            tare=0.0,
            adapt=0.0,
            touch=0.0,
            wait=0.0,
            ahead=(),
        )
