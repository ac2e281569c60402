"""A flight on the disk as it is flown: its record first, then the row of every tick."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from typing import Any

import numpy as np

from skylimb.analysis.exchange.recorder import FlightRecorder
from skylimb.analysis.exchange.run_topics import RowMessages, record_messages
from skylimb.analysis.recording.run import Run
from skylimb.base.packing import Layout
from skylimb.flight.flight_run import documented, flight_run
from skylimb.flight.plan import FlightPlan

_log = logging.getLogger(__name__)

CUT_OFF = "its record was cut off in flight"
"""Why a flight is no whole one of which this is all that is left."""


class RecordedTicks:
    """Gives a driver's rows to a recorder once it has begun; nothing where there is none.

    To make it takes up to seconds, to begin it none: between a look at a robot and its flight there are few.

    Args:
        recorder: of this flight, or None.
        plan: what is flown.
        layout: of the driver's rows.
    """

    def __init__(self, recorder: FlightRecorder | None, plan: FlightPlan, layout: Layout[Any]) -> None:
        self._recorder, self._layout, self._period = recorder, layout, plan.period
        self._said = set[str]()
        if recorder is not None:
            self._messages = RowMessages(self._run(plan), layout)

    @property
    def faults(self) -> Mapping[str, int]:
        """How often each fault of the recorder was met."""
        return {} if self._recorder is None else dict(self._recorder.faults)

    def begin(self) -> None:
        """Begin the flight's record."""
        if self._recorder is not None:
            self._recorder.take(self._messages.begin)

    def flown(self, k: int, row: np.ndarray) -> None:
        """Keep tick `k`; one that was flown before is flown anew from here."""
        if self._recorder is None:
            return
        self._recorder.take([self._messages.row(k * self._period, row)])
        for fault in self._recorder.faults.keys() - self._said:
            _log.warning("recorder: %s", fault)
        self._said = set(self._recorder.faults)

    def changed(self, plan: FlightPlan, at_once: bool) -> None:
        """Keep what is flown now, in the place of what was planned; no tick waits but for `at_once`."""
        if self._recorder is None:
            return
        if at_once:
            self._recorder.take(record_messages(self._run(plan)), anew=False)
        else:
            self._recorder.take_later(lambda: list(record_messages(self._run(plan))))

    def _run(self, plan: FlightPlan) -> Run:
        empty = {name: np.zeros((0, *shape)) for name, shape in self._layout.shapes.items()}
        return documented(flight_run(plan, empty, np.zeros(0), CUT_OFF), plan)
