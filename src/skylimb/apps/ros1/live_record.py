"""The record of a flight as it is flown: rows on a topic, and what is kept when there is time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from skylimb.analysis.exchange.lab_topics import ROW
from skylimb.analysis.exchange.run_topics import record_messages, row_names
from skylimb.analysis.recording.run import Run
from skylimb.apps.ros1.messages import Outgoing
from skylimb.apps.ros1.profile import PendingRun
from skylimb.apps.ros1.steered_rows import SteeredRecord
from skylimb.apps.ros1.tick import Tick
from skylimb.base.packing import Layout
from skylimb.control.loop.flight import Flight
from skylimb.control.missions.reference import Reference
from skylimb.flight.plan import FlightPlan


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
        self._begin = list(record_messages(empty.run(plan)))
        names = row_names(Run.of_content(self._begin[0][1]["data"], "record").log)[1:]
        self._order = [empty.layout.slices[name] for name in names]

    def add(self, tick: Tick, vehicle: np.ndarray) -> Iterator[Outgoing]:
        """Keep a tick that a controller flew, and publish it.

        Args:
            tick: as flown.
            vehicle: what the vehicle recorded of it.
        """
        if tick.reference is None or not tick.signals:
            return
        if self._record is None:
            self._record = self._fresh()
            yield from (Outgoing(*one) for one in self._begin)
        record, script = self._record, tick.script
        clock = 0.0
        if script is not None and script.begun:
            self._mission = self._mission or (script.name, record.ticks)
            clock = float(script.clock.ticks) * self._period
        time = record.ticks * self._period
        row = record.add(vehicle, tick.signals, clock, tick.flying.shown, tick.reference)
        yield Outgoing(ROW, {"data": np.concatenate([[time], *(row[part] for part in self._order)])})

    def mission_flown(self, tick: Tick) -> tuple[str, Callable[[], Flight]] | None:
        """The mission that is over at this tick, by name, and what makes its flight; None without one."""
        record, mission = self._record, self._mission
        if record is None or mission is None or (tick.script is not None and tick.script.begun):
            return None
        self._mission = None
        name, first = mission
        last = record.ticks - (1 if tick.signals else 0)
        return name, lambda: record.flight(first, last)

    def finish(self) -> PendingRun | None:
        """The whole flight; the next tick begins another one."""
        record, self._record, self._mission = self._record, None, None
        if record is None:
            return None
        return PendingRun("flight", lambda: record.run(self._plan))
