"""A simulated flight that is stepped from outside and ends as a run."""

from __future__ import annotations

from skylimb.analysis.notebook_run import Run
from skylimb.control.loop.loop import Loop
from skylimb.flight.drivers.world import world
from skylimb.flight.flying import simulated_driver
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import Takeoff


class SteppedFlight(Loop):
    """One flight, tick by tick.

        flight = skylimb.begin("paper", controller="hybrid")
        while flight.tick():
            force = flight.signal("contact_force")[-1]
        run = flight.finish()

    Args:
        takeoff: what is flown.

    Attributes:
        takeoff: what is flown.
    """

    def __init__(self, takeoff: Takeoff) -> None:
        driver, limits = simulated_driver(takeoff, world(takeoff)), takeoff.experiment.terminations
        super().__init__(driver, takeoff.mission, limits, takeoff.count)
        self.takeoff = takeoff

    def finish(self) -> Run:
        """The run; a flight that is stopped before its end has status FAILED and says so."""
        return scored_run(self.takeoff, self.stop())
