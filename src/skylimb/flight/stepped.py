"""A simulated flight that is stepped from outside and ends as a run."""

from __future__ import annotations

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.control.loop.loop import Loop
from skylimb.flight.simulated_run import recorded
from skylimb.flight.takeoff import Takeoff


class SteppedFlight:
    """One flight, tick by tick.

        flight = skylimb.begin("paper", controller="hybrid")
        while flight.tick():
            force = flight.signal("contact_force")[-1]
        run = flight.finish()

    Args:
        takeoff: what is flown.
        loop: its loop before the first tick.
    """

    def __init__(self, takeoff: Takeoff, loop: Loop) -> None:
        self.takeoff, self.loop = takeoff, loop

    @property
    def time(self) -> float:
        """Time since take-off, s."""
        return self.loop.time

    @property
    def over(self) -> bool:
        """Whether the flight has ended or is lost."""
        return self.loop.over

    def tick(self) -> bool:
        """Fly one control tick; false once the flight is over."""
        return self.loop.tick()

    def signal(self, name: str) -> np.ndarray:
        """The values of one signal so far, (ticks,) or (ticks, width)."""
        return self.loop.signal(name)

    def finish(self) -> Run:
        """The run; a flight that is stopped before its end has status FAILED and says so."""
        return recorded(self.takeoff, self.loop.finish())
