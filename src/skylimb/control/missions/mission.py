"""The mission as a table: one row for every tick, known before take-off."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skylimb.control.missions.clock import Clock, entries, reference_between
from skylimb.control.missions.frame import ContactFrame
from skylimb.control.missions.length import tick_count
from skylimb.control.missions.reference import Reference

PHASES = ("hover", "tare", "approach", "settle", "slide", "retreat", "hover_end", "lift")


@dataclass(frozen=True, eq=False)
class Mission:
    """The table of a flight.

    Attributes:
        times: of the ticks, s, (k,).
        period: time between two ticks, s; a flight that was stopped at once has one tick.
        reference: every entry with the ticks as first dimension.
        phase: index into `PHASES`, (k,).
        frame: axes of the task.
        tip_path: where the undisturbed tip would go on the nominal surface, W, m, (k, 3).
        contact: whether the mission touches anything.
        patience: how many times the mission's time a flight may take whose controller sets the pace.
    """

    times: np.ndarray
    period: float
    reference: Reference
    phase: np.ndarray
    frame: ContactFrame
    tip_path: np.ndarray
    contact: bool
    patience: float = 1.0

    @property
    def first(self) -> Reference:
        """What the mission asks for before take-off."""
        return self.row(0)

    def row(self, tick: int) -> Reference:
        """The reference at one tick."""
        return Reference(*(entry[tick] for entry in entries(self.reference)))

    def at(self, clock: Clock, preview: Sequence[int] = ()) -> Reference:
        """The reference of one clock.

        Args:
            clock: where the flight is.
            preview: how many ticks ahead each entry of `ahead` lies; beyond the end it is the last row.
        """
        here = int(clock.ticks)

        def read(ahead: int) -> Reference:
            row = self.row(min(here + ahead, len(self.times) - 1))
            if clock.ticks == here and clock.pace == 1.0:
                return row
            return reference_between(row, self.row(min(here + ahead + 1, len(self.times) - 1)), clock)

        return read(0)._replace(ahead=tuple(read(ticks) for ticks in preview))

    def in_phase(self, *names: str) -> np.ndarray:
        """Whether each tick belongs to one of these phases, (k,)."""
        return np.isin(self.phase, [PHASES.index(name) for name in names])

    def flight_times(self, paced: bool) -> np.ndarray:
        """Times since take-off of every tick that a flight may have, s; a paced flight may take longer.

        Raises:
            ConfigError: when a paced flight may take too long for its log to fit into memory.
        """
        if not paced:
            return self.times
        count = math.ceil(self.patience * len(self.times))
        what = f"the mission, {self.patience:g} times as long with phases.patience,"
        tick_count((count - 1) * self.period, self.period, what)
        return np.arange(count) * self.period

    def along(self, clock: Clock) -> Mission:
        """The mission as it was flown.

        Args:
            clock: where on the mission's clock each tick of the flight was (ticks) and the pace there,
                each (k,).
        """
        last = len(self.times) - 1
        here = np.minimum(np.floor(clock.ticks).astype(int), last)
        there = np.minimum(here + 1, last)

        def rows(index: np.ndarray) -> Reference:
            return Reference(*(entry[index] for entry in entries(self.reference)))

        part = (clock.ticks - np.floor(clock.ticks))[:, None]
        path = self.tip_path[here] + part * (self.tip_path[there] - self.tip_path[here])
        return dataclasses.replace(
            self,
            times=np.arange(len(here)) * self.period,
            reference=reference_between(rows(here), rows(there), clock),
            phase=self.phase[here],
            tip_path=path,
        )
