"""What share of the thrusts is commanded: a take-off brings it up and learns, a landing takes it down again.

    needs = lift that is commanded as the robot leaves the ground / its weight

The hover thrusts come up slowly, and their share that lifts the robot counts. All later thrusts are commanded
times that, behind the controller's back: it flies the robot that it knows. A controller that flew on the
ground would push against it; it begins in the air.

A robot that does not sink in its landing stands, or it has more thrust than its controller takes away. Height
alone does not tell them apart: so the share goes down, slowly, until the robot sinks, or until no robot flies
with what is left.
"""

from __future__ import annotations

from typing import NamedTuple

from skylimb.flight.realtime.landing import LOW

SPOOL = 1.0
"""Time in which the thrusts come up to a share that lifts no robot, s."""

SLOW, MOST, EASE = 0.2, 1.35, 0.2
"""How fast the share grows from there on, 1/s; the greatest one; how fast a landing takes it down, 1/s."""

RISEN, SURE, LAG = 0.01, 0.05, 0.05
"""Height above the ground that shows a lift-off, m, and for how long it has to, s, as one frame may be wrong;
by how much the thrusts lag their commands, s."""

OWN = 0.04
"""A scale that is nearer to one is taken for one: what is left of it is the control laws' affair."""


class Lift(NamedTuple):
    """How far a take-off is.

    Attributes:
        ground: height of the centre of gravity on the ground, m.
        share: of the thrusts that is commanded.
        lifted: whether the robot has left the ground.
        needs: the share that carries the robot; 1 until it is known.
        shown: for how long its height has shown a lift-off, s.
    """

    ground: float
    share: float = 0.0
    lifted: bool = False
    needs: float = 1.0
    shown: float = 0.0

    @property
    def failed(self) -> bool:
        """Whether the rotors do not lift the robot."""
        return not (self.lifted or self.shown) and self.share >= MOST

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
        shown = self.shown + dt if risen >= RISEN and self.share >= LOW else 0.0
        if shown < SURE:
            rate = LOW / SPOOL if self.share < LOW else SLOW
            return self._replace(share=min(self.share + rate * dt, MOST), shown=shown)
        # A share that has grown for t since lift-off has lifted by SLOW g t^3 / 6.
        scale = self.share - SLOW * ((6.0 * risen / (SLOW * gravity)) ** (1.0 / 3.0) + LAG)
        return self.carried(scale)

    def carried(self, scale: float) -> Lift:
        """In the air, with the share that was found to carry the robot."""
        needs = 1.0 if abs(scale - 1.0) < OWN else min(max(scale, LOW), MOST)
        return self._replace(share=needs, needs=needs, lifted=True)

    def lowered(self, dt: float) -> Lift:
        """A tick later, in a landing that does not sink."""
        return self._replace(share=max(self.share - EASE * dt, 0.0))

    def too_little(self, told: float) -> bool:
        """Whether no robot flies with so many times the hover thrusts: it stands, or it falls."""
        return told < LOW * self.needs
