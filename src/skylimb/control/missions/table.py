"""The packed references of a mission, as a compiled tick reads them: a block of rows for every tick."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skylimb.base.packing import Layout, pack_rows
from skylimb.control.missions.clock import Clock, reference_between
from skylimb.control.missions.mission import Mission
from skylimb.control.missions.reference import Reference


@dataclass(frozen=True)
class Window:
    """Which rows of the mission a tick reads: its own, the next one if the clock may stand between, and more.

    Attributes:
        preview: how many ticks ahead each entry of `reference.ahead` lies.
        paced: whether the controller sets the pace of the mission's clock.
    """

    preview: tuple[int, ...] = ()
    paced: bool = False

    @property
    def rows(self) -> int:
        """How many rows that are, from the row of the clock's whole tick on."""
        return 1 + max((0, *self.preview)) + (1 if self.paced else 0)

    def read(self, layout: Layout[Reference], flat: Any, clock: Clock) -> Reference:
        """The reference of a clock from its rows, one behind the other; on numbers and symbols alike."""

        def row(index: int) -> Reference:
            return layout.unpack(flat[index * layout.size : (index + 1) * layout.size])

        def at(index: int) -> Reference:
            return reference_between(row(index), row(index + 1), clock) if self.paced else row(index)

        return at(0)._replace(ahead=tuple(at(ticks) for ticks in self.preview))


def window_of(preview: Sequence[float], paced: bool, period: float) -> Window:
    """The window of a controller that wants the reference at these times ahead, s, in ticks of `period` s."""
    return Window(tuple(round(time / period) for time in preview), paced)


@functools.lru_cache(maxsize=8)
def reference_table(mission: Mission, layout: Layout[Reference], window: Window) -> np.ndarray:
    """One packed row for every tick of the mission, and copies of the last one for windows that go beyond.

    Returns:
        (ticks + extra, layout.size), read only, as flights of one mission share it. There is at least one
        extra row, so that a driver may fetch the row after the last.
    """
    rows = pack_rows(layout, mission.reference, len(mission.times))
    table = np.vstack([rows, np.repeat(rows[-1:], max(window.rows - 1, 1), axis=0)])
    table.setflags(write=False)
    return table
