"""A flight whose experiment is edited in flight.

Every live change is a *branch*: the experiment gets one more event, and the flight goes on from the present
tick with that experiment. So what is kept is what was flown, and nothing acts on a flight in another way.
"""

from __future__ import annotations

import numpy as np

from skylimb.control.loop.flight import Flight, mission_ticks
from skylimb.control.loop.loop import Loop
from skylimb.flight.drivers.compiled import CompiledDriver, Saved
from skylimb.flight.drivers.hooks import Hook, bound_places, pushing, standing, with_own_model, writing
from skylimb.flight.drivers.world import World
from skylimb.flight.events import Timeline
from skylimb.flight.experiments.experiment import Experiment
from skylimb.flight.flying import simulated_driver
from skylimb.flight.takeoff import Takeoff
from skylimb.simulation.surface_state import first_row

HISTORY = 30.0
"""Seconds that a flight can be rewound in a moment; to earlier times it is flown again from take-off."""

SPACING = 1.0
"""Seconds between two moments that are kept; what lies between them is flown again."""


class LiveFlight:
    """One take-off, flown tick by tick. Its first tick is flown at once: only then is known what is recorded.

    Args:
        takeoff: what is flown; its plant is left as it is.

    Attributes:
        takeoff: what is flown now.
        surface: state of the surface at every tick, as it is planned now, (ticks, width).

    Raises:
        SkylimbError: when the controller fails at its first tick.
    """

    def __init__(self, takeoff: Takeoff) -> None:
        self._first = takeoff
        self._acts: list[Hook] = []
        self._take_off()

    def _take_off(self) -> None:
        takeoff = self._first
        # Whatever is done to it later, nothing may be written into the take-off's own model.
        plant, self._data = with_own_model(takeoff.plant), takeoff.data()
        self._plant, self._standing = plant, standing(plant, self._data, takeoff.times)
        here = World(plant, self._data, (self._act,), Timeline())
        self._driver = simulated_driver(takeoff, here, whole=True, build=False)
        self._written: list[tuple[np.ndarray, np.ndarray]] = []
        # By tick: the driver's state before it, and what was flown from it on.
        self._moments: dict[int, Saved] = {}
        self._branches = {0: takeoff}
        self._loop = self._loop_from(0)
        self._use(takeoff)
        self.tick()

    def _act(self, k: int) -> None:
        for act in self._acts:
            act(k)

    def _loop_from(self, tick: int) -> Loop:
        takeoff = self.takeoff
        limits = takeoff.experiment.terminations
        return Loop(self._driver, takeoff.mission, limits, takeoff.count, start=tick)

    @property
    def takeoff(self) -> Takeoff:
        """What is flown now."""
        return next(reversed(self._branches.values()))

    @property
    def first(self) -> Experiment:
        """That it took off with."""
        return self._first.experiment

    @property
    def experiment(self) -> Experiment:
        """What is flown now, with every change that was made in flight."""
        return self.takeoff.experiment

    @property
    def ticks(self) -> int:
        """Ticks flown so far."""
        return self._loop.ticks

    @property
    def time(self) -> float:
        """Time since take-off, s, as it stands in the experiment's entries."""
        return round(self.ticks * self.takeoff.period, 9)

    @property
    def end(self) -> float:
        """Time at which the flight ends at the latest, s."""
        return round(len(self.takeoff.times) * self.takeoff.period, 9)

    @property
    def over(self) -> bool:
        """Whether the flight has ended or is lost."""
        return self._loop.over

    @property
    def recent(self) -> np.ndarray:
        """The signals of every tick so far, (ticks, size); `slices` says where each stands."""
        return self._driver.log[: self.ticks]

    @property
    def slices(self) -> dict[str, slice]:
        """Where each signal stands in a row."""
        return self._driver.layout.slices

    @property
    def mission_tick(self) -> int:
        """Where the flight is on the mission's clock, in whole ticks."""
        flight = Flight(self._driver.log, self._driver.layout, self.ticks, "")
        here = mission_ticks(self.takeoff.mission, flight, self.ticks - 1)
        return min(int(here[0]), len(self.takeoff.mission.times) - 1)

    def tick(self) -> bool:
        """Fly one tick; false once the flight is over.

        Raises:
            UserCodeError: when the controller fails; the flight is over then.
        """
        if self.over:
            return False
        k = self.ticks
        if isinstance(self._driver, CompiledDriver):
            self._save(k)
            if self._gains is not None:
                self._driver.gains[self._gains.columns] = self._gains.values[k]
        going = self._loop.tick()
        if self._loop.error is not None:
            raise self._loop.error
        return going

    def flight(self) -> Flight:
        """The flight so far; one that is not over counts as stopped here."""
        return self._loop.stopped()

    def go_on(self, takeoff: Takeoff) -> None:
        """Go on from here with a take-off that this one was changed to (`Takeoff.changed`)."""
        self._use(takeoff)
        self._branches[self.ticks] = takeoff

    def rewind(self, tick: int) -> None:
        """Go back to the moment after `tick` ticks, with the experiment of then.

        A moment of the last `HISTORY` seconds is there at once. What is older, and what a controller in
        Python flies, is flown again from take-off.

        Raises:
            UserCodeError: when a controller fails on the way.
        """
        tick = max(1, min(tick, self.ticks))
        branches = {at: takeoff for at, takeoff in self._branches.items() if at <= tick}
        moments = {at: saved for at, saved in self._moments.items() if at <= tick}
        if moments and isinstance(self._driver, CompiledDriver):
            last = max(moments)
            self._driver.put_back(moments[last])
            self._moments, self._branches = moments, branches
            self._loop = self._loop_from(last)
        else:
            self._take_off()
            self._branches = branches
        self._use(self.takeoff)
        while self.ticks < tick and self.tick():
            pass

    def _use(self, takeoff: Takeoff) -> None:
        """Let what changes in flight act from here on."""
        events = takeoff.timeline(takeoff.times)
        for numbers, before in self._written:
            numbers[:] = before
        if events.model is not None:
            self._written = [
                (numbers, numbers.copy()) for numbers, _ in bound_places(self._plant.model, events.model)
            ]
        self._gains = events.gains
        table = takeoff.surface_table
        self.surface = (
            np.tile(first_row(takeoff.plant.surface), (len(takeoff.times), 1)) if table is None else table
        )
        self._acts = [
            *writing(self._plant, events),
            *self._standing,
            *pushing(self._plant, self._data, events),
        ]

    def _save(self, tick: int) -> None:
        """Keep this moment where one is due."""
        assert isinstance(self._driver, CompiledDriver)
        every = max(1, round(SPACING / self.takeoff.period))
        if tick % every == 0 and tick not in self._moments:
            self._moments[tick] = self._driver.saved()
            oldest = tick - round(HISTORY / self.takeoff.period) - every
            self._moments = {at: kept for at, kept in self._moments.items() if at == 0 or at >= oldest}
