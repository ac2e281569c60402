"""A take-off learns its thrust: the hover thrusts come up slowly; their share that lifts the robot counts.

    scale = lift that is commanded as the robot leaves the ground / its weight

All later thrusts are commanded times that, behind the controller's back: it flies the robot that it knows. A
controller that flew on the ground would push against it; it begins in the air.
"""

from __future__ import annotations

from typing import NamedTuple

FREE, SPOOL = 0.7, 1.0
"""Share of the hover thrusts that no robot leaves the ground with, also one whose rotors give a quarter more,
and the time in which they come up to it, s."""

SLOW, MOST = 0.2, 1.35
"""How fast the share grows from there on, 1/s, and the greatest one."""

RISEN, LAG = 0.01, 0.05
"""Height above the ground that shows a lift-off, m; by how much the thrusts lag what they are told, s."""

OWN = 0.04
"""A scale that is nearer to one is taken for one: what is left of it is the control laws' affair."""


class Lift(NamedTuple):
    """How far a take-off is.

    Attributes:
        ground: height of the centre of gravity on the ground, m.
        share: of the thrusts that is commanded.
        lifted: whether the robot has left the ground.
    """

    ground: float
    share: float = 0.0
    lifted: bool = False

    @property
    def failed(self) -> bool:
        """Whether the rotors do not lift the robot."""
        return not self.lifted and self.share >= MOST

    def after(self, height: float | None, dt: float, gravity: float) -> Lift:
        """A tick later.

        Args:
            height: of the centre of gravity, m; None where it is not known: nobody leaves the ground blind.
            dt: s.
            gravity: m/s^2.
        """
        if self.lifted or self.failed or height is None:
            return self
        risen = height - self.ground
        if risen < RISEN or self.share < FREE:
            rate = FREE / SPOOL if self.share < FREE else SLOW
            return self._replace(share=min(self.share + rate * dt, MOST))
        # A share that has grown for t since lift-off has lifted by SLOW g t^3 / 6.
        scale = self.share - SLOW * ((6.0 * risen / (SLOW * gravity)) ** (1.0 / 3.0) + LAG)
        return self._replace(share=1.0 if abs(scale - 1.0) < OWN else scale, lifted=True)
