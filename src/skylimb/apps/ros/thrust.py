"""The thrust of one flight: what share of it is commanded, and whether that may carry the robot."""

from __future__ import annotations

import numpy as np

from skylimb.analysis.exchange.body import Body
from skylimb.apps.ros.lift import Lift
from skylimb.apps.ros.seen_thrust import SeenThrust
from skylimb.control.records import Command


class Thrust:
    """The share that is commanded, from tick to tick.

    Args:
        body: where the robot stands, or flies already.
        rises: whether it stands, and its rotors begin to turn.
        gravity: m/s^2.
        dt: control period, s.
        hover: thrusts of a robot that hovers, N, (n,).

    Attributes:
        lift: how far the take-off is, and what it has learned.
        hover: those of the posture that is commanded.
    """

    def __init__(self, body: Body, rises: bool, gravity: float, dt: float, hover: np.ndarray) -> None:
        ground = float(body.cog[2])
        self.lift = Lift(ground) if rises else Lift(ground, 1.0, True)
        self.hover = hover
        self._seen = None if rises else SeenThrust()
        self._gravity, self._dt = gravity, dt
        self._commanded = 1.0

    @property
    def light(self) -> bool:
        """Whether less was commanded of the rotors than any robot flies with."""
        return self.lift.too_little(self._commanded)

    def next(self, body: Body | None, eases: bool) -> None:
        """A tick later.

        Args:
            body: as measured; None where nothing fresh is.
            eases: whether a landing that does not sink takes thrust away.
        """
        if self._seen is not None:
            self._seen = self._seen.after(
                self._commanded, None if body is None else float(body.velocity[2]), self._dt
            )
            if self._seen.over:
                needs, self._seen = self._seen.needs(self._gravity), None
                self.lift = self.lift.carried(needs)
                return
        height = None if body is None else float(body.cog[2])
        self.lift = self.lift.lowered(self._dt) if eases else self.lift.after(height, self._dt, self._gravity)

    def commanded(self, command: Command, scale: float = 1.0) -> None:
        """Remember what is commanded of the rotors: so many times the thrusts of a command."""
        self._commanded = scale * float(np.sum(command.thrusts) / np.sum(self.hover))
