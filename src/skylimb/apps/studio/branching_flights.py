"""Live flights and the ways that they went: take-off, ticks, branches, undo and redo."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import datetime
from typing import Any

from skylimb.analysis.exchange.recorder import FlightRecorder
from skylimb.apps.studio.branches import Branches, Place
from skylimb.apps.studio.changes import alike_until, with_push
from skylimb.apps.studio.flight_setup import FlightSetup
from skylimb.apps.studio.good_gains import good_gains
from skylimb.apps.studio.live_flight import LiveFlight
from skylimb.apps.studio.live_flights import LiveFlights
from skylimb.apps.studio.watching import Watcher, files_of_controller
from skylimb.base.errors import ConfigError, SkylimbError
from skylimb.base.user_code import place_of
from skylimb.flight.experiments.experiment import Experiment

Say = Callable[[str, Any], None]
"""Takes the name of an event and what belongs to it."""

RESTARTED = "restarted"
"""What a change did that no flight can take in flight."""


class BranchingFlights:
    """Flights in lockstep whose every act is a branch; one thread calls it.

    Args:
        setup: what is flown.
        recorder: keeps the flights on the disk as they are flown.

    Attributes:
        say: takes the name of what happens and what belongs to it, its time among that.
        live: the flights, and what a page shows of them.
        branches: the ways that they went.
    """

    def __init__(self, setup: FlightSetup) -> None:
        self._recorder: FlightRecorder | None = None
        self.say: Say = lambda event, content: None
        self._good: FlightSetup | None = None
        self._begin(setup)
        self.branches = Branches()

    def _begin(self, setup: FlightSetup) -> None:
        """Take off anew; what cannot be flown raises, and leaves everything as it was."""
        self.live = live = LiveFlights(setup)
        self._was_over = False
        self._begun = datetime.now()
        if self._recorder is not None:
            self.record(self._recorder)
        self._watcher = Watcher(
            path
            for given, flight in zip(setup.controllers, live.flights, strict=True)
            for path in files_of_controller(given, flight.takeoff.controller)
        )

    def record(self, recorder: FlightRecorder) -> None:
        """Keep the flights on the disk as they are flown: these and those to come, each from its take-off."""
        self._recorder = recorder
        for number, flight in enumerate(self.live.flights, 1):
            flight.record(recorder.beside(str(number)))

    def _begin_again(self, setup: FlightSetup, why: str, act: str = "take off again") -> None:
        before, self._good = self.here(), self._good_now()
        self._begin(setup)
        self.branches = self.branches.acted(before, why or act, "").began(before, why or "take-off")
        self._tell(RESTARTED, why=why)
        self._tell("scene")

    def _good_now(self) -> FlightSetup | None:
        """Whose gains flew well: those of these flights, else of those before; None where there are none."""
        gains = good_gains(self.live)
        return self._good if gains is None else replace(self.live.setup, gains=gains)

    def here(self) -> Place:
        """What repeats the flights up to now."""
        live = self.live
        experiments = tuple(flight.experiment for flight in live.flights)
        return Place(live.begun, live.setup, experiments, round(live.time / live.period), live.time)

    def advance(self, ticks: int) -> int:
        """Fly some ticks of every flight that goes on; returns how many, 0 when all are over."""
        flown = 0
        while flown < ticks and not self.live.over:
            for number, flight in enumerate(self.live.flights):
                self._try(number, flight.tick)
            flown += 1
        if self.live.over and not self._was_over:
            self._tell("over", verdict=self.live.verdict)
        self._was_over = self.live.over
        return flown

    def _branch(self, experiments: Mapping[LiveFlight, Experiment], words: str, kind: str) -> None:
        """Go on with other experiments, as an act that can be undone."""
        before = self.here()
        self.live.branch(experiments)
        self.branches = self.branches.acted(before, words, kind)

    def scores(self) -> dict[str, Any]:
        """The scores so far (`LiveFlights.scores`), and of what: the branch `here`, `until` a time, s.

        `over` says whether there is no more to come.
        """
        of = {"here": self.branches.here, "until": self.live.time, "over": self.live.over}
        return {**self.live.scores(), **of}

    def rewind(self, time: float) -> None:
        """Go back to a time (s); what comes then is flown anew, without what people did from that time on."""
        if not (math.isfinite(time) and time >= 0.0):
            raise ConfigError(f"time = {time:g} s to go back to should be 0 or more")
        before, live = self.here(), self.live
        tick = max(1, min(round(time / live.period), before.ticks))
        for number, flight in enumerate(live.flights):
            self._try(number, lambda flight=flight: flight.rewind(tick))
        branches = self.branches.acted(before, f"back to {live.time:.1f} s", "")
        self._came(branches.came_to(before, self.branches.here, live.time), live.time)

    def undo(self) -> None:
        """Go back to the moment before the last act."""
        self._go_to(*self.branches.undo(self.here()))

    def redo(self) -> None:
        """Go to where the flights were when the last act was undone."""
        self._go_to(*self.branches.redo(self.here()))

    def jump(self, branch: int) -> None:
        """Go to where another way was left."""
        place = self.branches.end_of(branch)
        self._go_to(self.branches.acted(self.here(), "to another branch", ""), place)

    def _go_to(self, branches: Branches, place: Place) -> None:
        before, live = self.here(), self.live
        if place.begun is not live.begun:
            self._begin(place.begun)
            live = self.live
        ready = [
            flight.takeoff.changed(with_push(experiment, flight.first, place.time))
            for flight, experiment in zip(live.flights, place.experiments, strict=True)
        ]
        since = 0.0
        if live.begun is before.begun:
            times = (
                alike_until(one.experiment, to.experiment)
                for one, to in zip(live.flights, ready, strict=True)
            )
            since = min(before.time, place.time, *times)
        else:
            self._tell("scene")
        for number, (flight, takeoff) in enumerate(zip(live.flights, ready, strict=True)):
            self._try(number, lambda flight=flight, takeoff=takeoff: flight.come_to(takeoff, place.ticks))
        live.setup = place.setup
        self._came(branches.came_to(before, place.branch, place.time), since)

    def _came(self, branches: Branches, since: float) -> None:
        """The flights are at another moment; what was flown there from `since` (s) on is sent anew."""
        self.branches = branches
        self._was_over = self.live.over
        self._tell("moved", since=since)

    def _try(self, flight: int | None, act: Callable[[], object], flying: str = "") -> None:
        """Do something that runs the user's code; what goes wrong there is an event, and ends nothing.

        Args:
            flight: that does it; None for all.
            act: what is done.
            flying: what goes on flying when it goes wrong.
        """
        try:
            act()
        except SkylimbError as error:
            what: dict[str, Any] = {"flying": flying} if flight is None else {"flight": flight}
            if place := place_of(error):  # in a file of the user's
                what |= {"file": place.file, "line": place.line}
            self._tell("error", text=str(error), **what)

    def _tell(self, event: str, **what: Any) -> None:
        self.say(event, {"time": self.live.time, **what})
