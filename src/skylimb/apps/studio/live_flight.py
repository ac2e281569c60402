"""A flight whose experiment is edited in flight.

Every live change is a *branch*: the experiment gets one more event, and the flight goes on from the present
tick with that experiment. So what is kept is what was flown, and nothing acts on a flight in another way.
"""

from __future__ import annotations

import numpy as np

from skylimb.analysis.exchange.recorder import FlightRecorder
from skylimb.apps.studio.changes import alike_until, as_of
from skylimb.control.loop.flight import Flight, mission_clock
from skylimb.control.loop.loop import Loop
from skylimb.control.missions.clock import Clock
from skylimb.control.missions.mission import Mission
from skylimb.flight.drivers.compiled import CompiledDriver, Saved
from skylimb.flight.drivers.hooks import Hook, bound_places, pushing, standing, with_own_model, writing
from skylimb.flight.drivers.world import World
from skylimb.flight.events import Timeline
from skylimb.flight.experiments.experiment import Experiment
from skylimb.flight.flying import simulated_driver
from skylimb.flight.recorded_ticks import RecordedTicks
from skylimb.flight.takeoff import Takeoff
from skylimb.simulation.surface_state import first_row

HISTORY = 30.0
"""Seconds in which every moment is kept; of what was before it, every tenth."""

SPACING = 1.0
"""Seconds between two moments that are kept; what lies between them is flown again."""

SETTLED = 3.0
"""Seconds without a change after which the record of what is flown is made anew: that takes a thread some
50 ms, in which the next change would take twice as long."""

_FRAMES = ("body_sameframe", "geom_sameframe", "site_sameframe")


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
        self._record: RecordedTicks | None = None
        self._changed: int | None = None
        self._take_off()

    def _take_off(self) -> None:
        takeoff = self._first
        # Whatever is done to it later, nothing may be written into the take-off's own model.
        plant, self._data = with_own_model(takeoff.plant), takeoff.data()
        self._plant, self._standing = plant, standing(plant, self._data, takeoff.times)
        here = World(plant, self._data, (self._act,), Timeline())
        self._driver = simulated_driver(takeoff, here, whole=True, build=False)
        if isinstance(self._driver, CompiledDriver):
            self._own_gains = self._driver.gains.copy()
        # What may be written into the model, as it was: with short cuts of the engine (`bound_places`).
        self._written: list[tuple[np.ndarray, np.ndarray]] = []
        self._frames = {name: getattr(plant.model, name).copy() for name in _FRAMES}
        # By tick: the driver's state before it, and what was flown from it on.
        self._moments: dict[int, Saved] = {}
        self._use(takeoff)
        self._loop = self._loop_from(0)
        self.tick()

    def _act(self, k: int) -> None:
        for act in self._acts:
            act(k)

    def _loop_from(self, tick: int) -> Loop:
        takeoff = self.takeoff
        limits = takeoff.experiment.terminations
        return Loop(self._driver, takeoff.mission, limits, takeoff.count, start=tick)

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
    def lasts(self) -> float:
        """Time that the mission takes at its own pace, s."""
        return round(len(self.takeoff.mission.times) * self.takeoff.period, 9)

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

    def asked(self, ticks: int) -> Mission:
        """The mission at the last of some ticks, as it was flown; every entry has one row."""
        flight, mission = Flight(self._driver.log, self._driver.layout, ticks, ""), self._mission
        clock = mission_clock(mission, flight)
        return mission.along(Clock(clock.ticks[-1:], clock.pace[-1:]))

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
        if self._record is not None and self.ticks > k:
            self._keep(self._record, k)
        if self._loop.error is not None:
            raise self._loop.error
        return going

    def record(self, recorder: FlightRecorder) -> None:
        """Keep all ticks on the disk as they are flown, with those that were."""
        self._record = RecordedTicks(recorder, self.takeoff, self._driver.layout)
        self._record.begin()
        for k in range(self.ticks):
            self._record.flown(k, self._driver.log[k])

    def _keep(self, record: RecordedTicks, k: int) -> None:
        # A hand on a slider makes a branch a frame, and what is flown takes some 50 ms to put into words.
        since = None if self._changed is None else k - self._changed
        if since is not None and (since > SETTLED / self.takeoff.period or self.over):
            record.changed(self.takeoff, self.over)
            self._changed = None
        record.flown(k, self._driver.log[k])

    def flight(self) -> Flight:
        """The flight so far; one that is not over counts as stopped here."""
        return self._loop.stopped()

    def come_to(self, takeoff: Takeoff, tick: int) -> None:
        """Go to the moment after `tick` ticks of a take-off that this one was changed to (`Takeoff.changed`).

        What both have in common is not flown again, from the last moment that is kept; but what a controller
        in Python has flown is, from take-off.

        Raises:
            UserCodeError: when a controller fails on the way.
        """
        tick = max(1, tick)
        alike = alike_until(self.experiment, takeoff.experiment) / self.takeoff.period
        common = int(min(tick, self.ticks, alike + 1e-6))
        if common < self.ticks or self.over:
            moments = {at: saved for at, saved in self._moments.items() if at <= common}
            if moments and isinstance(self._driver, CompiledDriver):
                last = max(moments)
                self._driver.put_back(moments[last])
                self._moments = moments
                self._loop = self._loop_from(last)
            else:
                self._take_off()
        self._use(takeoff)
        self._changed = self.ticks
        while self.ticks < tick and self.tick():
            pass

    def rewind(self, tick: int) -> None:
        """Go back to the moment after `tick` ticks, and leave out what people did from then on."""
        tick = max(1, min(tick, self.ticks))
        self.come_to(self.as_of(tick), tick)

    def as_of(self, tick: int) -> Takeoff:
        """What was flown up to a tick, without what people did from then on."""
        time = round(tick * self.takeoff.period, 9)
        return self.takeoff.changed(as_of(self.experiment, self.first, time))

    def _use(self, takeoff: Takeoff) -> None:
        """Let what changes in flight act from here on."""
        self.takeoff, self._mission = takeoff, takeoff.mission  # each look at a take-off's seeks it anew
        if isinstance(self._driver, CompiledDriver):
            self._driver.gains[:] = self._own_gains
        events = takeoff.timeline(takeoff.times)
        for numbers, before in self._written:
            numbers[:] = before
        for name, before in self._frames.items():
            getattr(self._plant.model, name)[:] = before
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
            self._moments = {
                at: kept for at, kept in self._moments.items() if at >= oldest or at % (10 * every) == 0
            }
