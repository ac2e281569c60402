"""The record of a flight as it is flown: rows on a topic, and what is kept when there is time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from skylimb.analysis.exchange.own_topics import row_names
from skylimb.analysis.recording.run import Run
from skylimb.apps.ros1 import topics
from skylimb.apps.ros1.outputs import Outgoing
from skylimb.apps.ros1.record import SteeredRecord
from skylimb.apps.ros1.tick import Tick
from skylimb.base.packing import Layout
from skylimb.control.estimation.records import Measurement
from skylimb.control.loop.flight import Flight
from skylimb.control.missions.reference import Reference
from skylimb.flight.plan import FlightPlan

FILE = "log.nc"
"""What the record is called on its topic."""


class Kept(NamedTuple):
    """Something worth keeping: its name, and what makes its run, which takes too long for a tick."""

    name: str
    run: Callable[[], Run]


class LiveRecord:
    """Keeps every tick of one flight after another.

    Args:
        plan: robot, experiment, and the controller as it was loaded, before it was compiled.
        layout: of what the vehicle records.
        sample: the controller's signals and the reference of any tick.
    """

    def __init__(
        self,
        plan: FlightPlan,
        layout: Layout[dict[str, Any]],
        sample: tuple[Mapping[str, Any], Reference],
    ) -> None:
        self._plan, self._period = plan, plan.period
        paced = plan.needs.paced
        self._fresh = lambda: SteeredRecord(layout, *sample, paced)
        self._record: SteeredRecord | None = None
        self._mission: tuple[str, int] | None = None
        empty = self._fresh()
        begun = self._run(empty, 0)
        self._content, self._sources = begun.content(), begun.sources
        names = row_names(Run.of_content(self._content, "record").log)[1:]
        self._order = [empty.layout.slices[name] for name in names]

    def add(self, tick: Tick, vehicle: np.ndarray) -> Iterator[Outgoing]:
        """Keep a tick that a controller flew, and tell of it.

        Args:
            tick: as flown.
            vehicle: what the vehicle recorded of it.
        """
        if tick.reference is None or not tick.signals:
            return
        if self._record is None:
            self._record = self._fresh()
            yield Outgoing(topics.RECORD, (FILE, self._content))
            for source in self._sources.items():
                yield Outgoing(topics.SOURCE, source)
        record, script = self._record, tick.script
        clock = 0.0
        if script is not None and script.begun:
            self._mission = self._mission or (script.name, record.ticks)
            clock = float(script.clock.ticks) * self._period
        time = record.ticks * self._period
        row = record.add(vehicle, tick.signals, clock, tick.flying.shown, tick.reference)
        yield Outgoing(topics.ROW, np.concatenate([[time], *(row[part] for part in self._order)]))

    def mission_flown(self, tick: Tick) -> tuple[str, Callable[[], Flight]] | None:
        """The mission that is over at this tick, by name, and what makes its flight; None without one."""
        record, mission = self._record, self._mission
        if record is None or mission is None or (tick.script is not None and tick.script.begun):
            return None
        self._mission = None
        name, first = mission
        last = record.ticks - (1 if tick.signals else 0)
        return name, lambda: record.flight(first, last)

    def finish(self) -> Kept | None:
        """The whole flight; the next tick begins another one."""
        record, self._record, self._mission = self._record, None, None
        if record is None:
            return None
        return Kept("flight", lambda: self._run(record, record.ticks))

    def _run(self, record: SteeredRecord, rows: int) -> Run:
        return record.run(self._plan, rows)


def measured_row(measurement: Measurement, tick: Tick) -> np.ndarray:
    """Measurement and command of a tick, in the order of `measured_layout`."""
    return np.concatenate([*measurement, *tick.command])
