"""The record of a flight that its user steers, as it is flown: rows on a topic, and what is kept afterwards.

A row a tick, from the controller's first one on, with the tick's whole reference in it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from skylimb.analysis.exchange.run_topics import RowMessages
from skylimb.analysis.recording.run import Run
from skylimb.apps.ros.messages import Outgoing
from skylimb.apps.ros.profile import PendingRun
from skylimb.apps.ros.tick import Tick
from skylimb.base.packing import Layout, flattened
from skylimb.base.signals import Signal
from skylimb.control.loop.flight import MISSION_TIME, Flight
from skylimb.control.missions.reference import Reference
from skylimb.flight.flight_run import documented, flight_run
from skylimb.flight.plan import FlightPlan
from skylimb.flight.replay.whole_reference import REFERENCE_SIGNALS, reference_signals

STATE, SCALE = "flight_state", "thrust_scale"
_MORE = {
    STATE: Signal("", "", "flight state, as on the lab's topic", "estimate"),
    SCALE: Signal("", "", "thrusts that the rotors are commanded, over those of the controller", "command"),
    MISSION_TIME: Signal(
        "s", "", "where the flight is on its mission's clock; 0 without a mission", "reference"
    ),
}


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
        signals, reference = sample
        self._plan, self._paced, self._own = plan, plan.needs.paced, tuple(signals)
        vehicle = {name: np.zeros(shape) if shape else 0.0 for name, shape in layout.shapes.items()}
        own = {name: np.asarray(value, dtype=float) for name, value in signals.items()}
        flown = {**vehicle, **own, **({MISSION_TIME: 0.0} if self._paced else {})}
        self._flown = Layout(flown)
        self._layout = Layout({**flown, STATE: 0.0, SCALE: 1.0, **reference_signals(reference)})
        self._rows = list[np.ndarray]()
        self._mission: tuple[str, int] | None = None
        self._messages = RowMessages(self._run([]), self._layout)

    def add(self, tick: Tick, vehicle: np.ndarray) -> Iterator[Outgoing]:
        """Keep a tick that a controller flew, and publish it.

        Args:
            tick: as flown.
            vehicle: what the vehicle recorded of it.
        """
        if tick.reference is None or not tick.signals:
            return
        if not self._rows:
            yield from (Outgoing(*one) for one in self._messages.begin)
        count, script, clock = len(self._rows), tick.script, 0.0
        if script is not None and script.begun:
            self._mission = self._mission or (script.name, count)
            clock = float(script.clock.ticks) * self._plan.period
        own = (tick.signals[name] for name in self._own)
        more = (*((clock,) if self._paced else ()), tick.flying.shown, tick.scale)
        row = flattened((vehicle, *own, *more, *tick.reference.entries))
        self._rows.append(row)
        yield Outgoing(*self._messages.row(count * self._plan.period, row))

    def mission_flown(self, tick: Tick) -> tuple[str, Callable[[], Flight]] | None:
        """The mission that is over at this tick, by name, and what makes its flight; None without one.

        The flight is without the signals that no mission needs.
        """
        rows, mission = self._rows, self._mission
        if mission is None or (tick.script is not None and tick.script.begun):
            return None
        self._mission = None
        name, first = mission
        last = len(rows) - (1 if tick.signals else 0)
        return name, lambda: Flight(
            self._table(rows[first:last])[:, : self._flown.size], self._flown, last - first, ""
        )

    def finish(self) -> PendingRun | None:
        """The whole flight, without scores; the next tick begins another one."""
        rows, self._rows, self._mission = self._rows, [], None
        return PendingRun("flight", lambda: self._run(rows)) if rows else None

    def _table(self, rows: Sequence[np.ndarray]) -> np.ndarray:
        """Rows as (ticks, width), also where there are none."""
        return np.array(rows).reshape(-1, self._layout.size)

    def _run(self, rows: Sequence[np.ndarray]) -> Run:
        count, table = len(rows), self._table(rows)
        values = {
            name: table[:, part].reshape(count, *self._layout.shapes[name])
            for name, part in self._layout.slices.items()
        }
        times = np.arange(count) * self._plan.period
        made = flight_run(self._plan, values, times, declared={**_MORE, **REFERENCE_SIGNALS})
        return documented(made, self._plan)
