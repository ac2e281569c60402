"""The record of a flight that its user steers: one row a tick, its whole reference in it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.base.packing import Layout
from skylimb.base.signals import Signal
from skylimb.control.loop.flight import MISSION_TIME, Flight
from skylimb.control.missions.reference import Reference
from skylimb.flight.flight_run import documented, flight_run
from skylimb.flight.plan import FlightPlan
from skylimb.flight.replay.whole_reference import REFERENCE_SIGNALS, reference_signals

STATE = "flight_state"
_MORE = {
    STATE: Signal("", "", "flight state, as on the lab's topic", "estimate"),
    MISSION_TIME: Signal(
        "s", "", "where the flight is on its mission's clock; 0 without a mission", "reference"
    ),
}


class SteeredRecord:
    """Rows of a flight, from the controller's first tick on.

    Args:
        vehicle: layout of what the vehicle records.
        own: the controller's own signals at that tick.
        reference: of that tick.
        paced: whether the controller sets the pace of missions.
    """

    def __init__(
        self, vehicle: Layout[dict[str, Any]], own: Mapping[str, Any], reference: Reference, paced: bool
    ) -> None:
        zeros = {name: np.zeros(shape) if shape else 0.0 for name, shape in vehicle.shapes.items()}
        mine = {name: np.asarray(value, dtype=float) for name, value in own.items()}
        self._paced, self._own = paced, tuple(mine)
        flown = {**zeros, **mine, **({MISSION_TIME: 0.0} if paced else {})}
        self.flown = Layout(flown)
        self.layout = Layout({**flown, STATE: 0.0, **reference_signals(reference)})
        self._rows = list[np.ndarray]()

    @property
    def ticks(self) -> int:
        """Rows so far."""
        return len(self._rows)

    def add(
        self,
        vehicle: np.ndarray,
        own: Mapping[str, Any],
        mission_time: float,
        state: int,
        reference: Reference,
    ) -> np.ndarray:
        """One more row."""
        parts = [vehicle, *(np.ravel(np.asarray(own[name], dtype=float)) for name in self._own)]
        clock = (mission_time,) if self._paced else ()
        values = [np.ravel(value) for value in reference_signals(reference).values()]
        # What is there already is not copied in flight.
        self._rows.append(np.concatenate([*parts, clock, (float(state),), *values]))
        return self._rows[-1]

    def _all(self) -> np.ndarray:
        """Every row so far, (ticks, width)."""
        return np.array(self._rows).reshape(-1, self.layout.size)

    def flight(self, first: int, last: int, cause: str = "") -> Flight:
        """Some ticks as the flight of their mission, without the signals that no mission needs."""
        rows = self._all()[first:last, : self.flown.size]
        return Flight(rows, self.flown, last - first, cause)

    def run(self, plan: FlightPlan) -> Run:
        """The run of all of them, without scores."""
        count, values, whole = self.ticks, {}, self._all()
        for name, part in self.layout.slices.items():
            values[name] = whole[:, part].reshape(count, *self.layout.shapes[name])
        times = np.arange(count) * plan.period
        made = flight_run(plan, values, times, declared={**_MORE, **REFERENCE_SIGNALS})
        return documented(made, plan)
