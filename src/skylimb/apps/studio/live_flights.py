"""Live flights beside each other, in lockstep, and everything that a page shows of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from skylimb.analysis.figures.palette import colours_of, label
from skylimb.apps.studio.changes import settled_gains
from skylimb.apps.studio.controls import controls_of
from skylimb.apps.studio.flight_setup import FlightSetup
from skylimb.apps.studio.frames import FlightView
from skylimb.apps.studio.live_flight import LiveFlight
from skylimb.flight.experiments.experiment import Experiment

RUNNING, PAUSED, OVER = 0, 1, 2
"""State of a session in a frame."""

_HEAD = 3  # numbers of a frame before those of the flights: time, speed, state


class LiveFlights:
    """The flights of a setup, from take-off.

    Args:
        setup: what is flown.

    Attributes:
        setup: of the next take-off.
        begun: of this one.
        known: the controls at take-off by their keys: what may be set, and when that acts.

    Raises:
        SkylimbError: when a flight of it cannot be flown.
    """

    def __init__(self, setup: FlightSetup) -> None:
        self.setup = self.begun = setup
        self.flights = tuple(LiveFlight(takeoff) for takeoff in setup.takeoffs())
        self.known = {control["key"]: control for control in self.controls()}
        controllers = [flight.takeoff.controller.name for flight in self.flights]
        self.names = numbered(controllers, "-")
        self._views = [
            FlightView(flight, name, colour)
            for flight, name, colour in zip(
                self.flights, numbered(map(label, controllers), " "), colours_of(controllers), strict=True
            )
        ]

    @property
    def period(self) -> float:
        """Of a tick, s."""
        return self.flights[0].takeoff.period

    @property
    def time(self) -> float:
        """Time since take-off of the flight that came farthest, s."""
        return max(flight.time for flight in self.flights)

    @property
    def end(self) -> float:
        """Time at which the flights end at the latest, s."""
        return max(flight.end for flight in self.flights)

    @property
    def over(self) -> bool:
        """Whether no flight goes on."""
        return all(flight.over for flight in self.flights)

    @property
    def verdict(self) -> list[str]:
        """Of each flight, in words: that it flies, that it is over, or why it was lost."""
        return [_verdict(flight) for flight in self.flights]

    @property
    def going(self) -> list[LiveFlight]:
        """The flights that are not over."""
        return [flight for flight in self.flights if not flight.over]

    @property
    def shown(self) -> LiveFlight:
        """The flight whose surface and events are shown: the first one that goes on."""
        return next(iter(self.going), self.flights[0])

    def branch(self, experiments: Mapping[LiveFlight, Experiment]) -> None:
        """Let flights go on with other experiments; all or none.

        Raises:
            SkylimbError: when one of them cannot; nothing has changed then.
        """
        ready = {flight: flight.takeoff.changed(experiment) for flight, experiment in experiments.items()}
        for flight, takeoff in ready.items():
            flight.come_to(takeoff, flight.ticks)

    def gains(self) -> tuple[dict[str, Any], ...]:
        """The gains of each flight that the setup has changed, with what has changed in flight."""
        given = self.setup.gains or ({},) * len(self.flights)
        return tuple(
            {**own, **settled_gains(flight.experiment, first=flight.first)}
            for own, flight in zip(given, self.flights, strict=True)
        )

    def gains_now(self, number: int) -> dict[str, Any]:
        """The gains of a flight that changed since take-off, with what they come to."""
        flight = self.flights[number]
        return settled_gains(flight.experiment, flight.time)

    def controls(self) -> list[dict[str, Any]]:
        """Every gain and key as a control; see `controls.controls_of`."""
        return controls_of(self.flights)

    def scores(self) -> dict[str, Any]:
        """The scores so far of every flight; see `scores.score_table`."""
        from skylimb.apps.studio.scores import score_table  # slow to import

        return score_table(
            {view.name: flight for view, flight in zip(self._views, self.flights, strict=True)}
        )

    def scene(self) -> dict[str, Any]:
        """What a page needs once, ready for JSON: each flight's scene, and where a frame's numbers are."""
        layout: list[dict[str, list[int]]] = []
        at = _HEAD
        for view in self._views:
            places = {}
            for name, numbers in view.values().items():
                places[name] = [at, at + len(numbers)]
                at += len(numbers)
            layout.append(places)
        return {
            "experiment": self.flights[0].experiment.name,
            "period": self.period,
            "lasts": max(flight.lasts for flight in self.flights),
            "layout": {"time": 0, "speed": 1, "state": 2, "flights": layout, "size": at},
            "flights": [view.scene() for view in self._views],
        }

    def frame(self, speed: float, paused: bool, ticks: int | None = None) -> np.ndarray:
        """What a page needs of a moment: time, speed, state, each flight's numbers (`scene()["layout"]`).

        Args:
            speed: over real time.
            paused: whether nothing is flown.
            ticks: after which it comes; after all that were flown when None.
        """
        time = self.time if ticks is None else ticks * self.period
        state = OVER if self.over and ticks is None else PAUSED if paused else RUNNING
        head = np.array([time, speed, state])
        flights = [numbers for view in self._views for numbers in view.values(ticks).values()]
        return np.concatenate([head, *flights]).astype(np.float32)

    def frames(self, since: int, period: float) -> list[np.ndarray]:
        """The frames of the flights from a tick on, every `period` (s)."""
        last, every = round(self.time / self.period), max(1, round(period / self.period))
        return [self.frame(0.0, False, ticks) for ticks in range(max(1, since), last, every)]


def numbered(names: Iterable[str], between: str) -> list[str]:
    """The names, with a number where two are alike: "pid", "pid-2"."""
    found: list[str] = []
    for name in names:
        called, number = name, 2
        while called in found:
            called, number = f"{name}{between}{number}", number + 1
        found.append(called)
    return found


def _verdict(flight: LiveFlight) -> str:
    if not flight.over:
        return "flying"
    return flight.flight().cause or "came to its end"
