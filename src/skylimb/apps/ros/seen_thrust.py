"""What thrust the rotors need, as the robot's motion shows it: for whoever takes over a robot that flies.

    needs = thrust that is commanded, in hover thrusts / thrust that is seen, 1 + acceleration up / g

A take-off learns that as it leaves the ground (`lift`). A node that begins anew finds the robot in the air,
and what the one before had learned is gone with it. Nobody sends it again: commands are not latched, and
`motor_pwms` are duties, which only `motor_info` and the voltage turn into thrusts. But whoever takes over
sees where the robot is, and knows what it commands itself: half a second of both is enough. No
accelerometer is asked, as not every robot has one, and its unit may be wrong.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from skylimb.apps.ros.lift import LAG, MOST
from skylimb.flight.realtime.landing import LOW

AFTER, FOR, LEAST = 4.0 * LAG, 0.4, 20
"""How long the rotors take to follow their commands, s; for how long it is then looked, s, and how often at
least."""


class Sample(NamedTuple):
    """Of a tick: its time, s, the thrust, in hover thrusts, and the speed up, m/s."""

    time: float
    thrust: float
    speed: float


class SeenThrust(NamedTuple):
    """What was commanded and seen so far.

    Attributes:
        time: since the first command, s.
        thrust: of now, in hover thrusts, as the rotors follow their commands.
        samples: that were looked at.
    """

    time: float = 0.0
    thrust: float = 1.0
    samples: tuple[Sample, ...] = ()

    def after(self, told: float, speed: float | None, dt: float) -> SeenThrust:
        """A tick later.

        Args:
            told: thrust that was commanded last, in hover thrusts.
            speed: up, m/s; None where it is not known.
            dt: s.
        """
        time, thrust = self.time + dt, self.thrust + dt / LAG * (told - self.thrust)
        seen = () if speed is None or time < AFTER else (Sample(time, thrust, speed),)
        return SeenThrust(time, thrust, self.samples + seen)

    @property
    def over(self) -> bool:
        """Whether it was looked for long enough."""
        return self.time >= AFTER + FOR

    def needs(self, gravity: float) -> float:
        """The share that carries the robot; 1 where that cannot be seen.

        Args:
            gravity: m/s^2.
        """
        if len(self.samples) < LEAST:
            return 1.0
        times, thrusts, speeds = np.array(self.samples).T
        carried = 1.0 + float(np.polyfit(times, speeds, 1)[0]) / gravity
        scale = float(thrusts.mean()) / carried if carried > 0.0 else MOST
        # A robot that moves as no rotors move it is held, or thrown: its rotors are believed.
        return scale if LOW <= scale <= MOST else 1.0
