"""The mission's own clock, and the one interpolation of the reference between two of its ticks.

A controller may slow the mission down, or let a rest go by: it sets a pace with every tick, 1 for the
mission's own and 0 to wait. The clock then stands between two rows of the mission's table. The reference in
between is linear in every entry; its rates scale with the pace, its accelerations with the square of the
pace, so that the velocity stays the derivative of the position at any constant pace.

Drivers use this with numbers or symbols for one tick, the log with arrays for a whole flight.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from skylimb.control.missions.reference import ACCELERATIONS, RATES, Reference
from skylimb.symbolic import floor, where

FASTEST = 100.0
"""No mission goes faster than this many times its own pace."""


class Clock(NamedTuple):
    """Where a flight is on the mission's clock, in ticks, and the pace of that clock (1 is its own speed)."""

    ticks: Any
    pace: Any


def start_of_mission() -> Clock:
    """The clock before the first tick."""
    return Clock(0.0, 1.0)


def next_clock(clock: Clock, pace: Any) -> Clock:
    """The clock one tick later. A pace that is negative, too large or not a number is limited to 0 .. 100."""
    pace = limited_pace(pace)
    return Clock(clock.ticks + pace, pace)


def limited_pace(pace: Any) -> Any:
    """The pace within 0 .. 100; 0 for a number that is not finite or negative."""
    return where(pace > 0.0, where(pace < FASTEST, pace, FASTEST), 0.0)


def reference_between(here: Reference, there: Reference, clock: Clock) -> Reference:
    """The reference of a clock between two ticks.

    Args:
        here: the row at the clock's last whole tick, or such rows for many clocks: entries (k, ...).
        there: the row after it.
        clock: where the flight is; for many rows `ticks` and `pace` are (k,).
    """
    part = clock.ticks - floor(clock.ticks)
    mixed = Reference(
        *(a + _spread(part, a) * (b - a) for a, b in zip(entries(here), entries(there), strict=True))
    )
    pace = {name: _spread(clock.pace, getattr(mixed, name)) for name in (*RATES, *ACCELERATIONS)}
    return mixed._replace(
        **{name: getattr(mixed, name) * pace[name] for name in RATES},
        **{name: getattr(mixed, name) * pace[name] ** 2 for name in ACCELERATIONS},
    )


def entries(reference: Reference) -> tuple[Any, ...]:
    """The entries of a reference but for what lies ahead of it."""
    return tuple(reference)[:-1]


def _spread(weight: Any, entry: Any) -> Any:
    """A weight for each row, shaped so that it multiplies the entries of its row."""
    if isinstance(weight, np.ndarray) and weight.ndim == 1 and isinstance(entry, np.ndarray):
        return weight.reshape(-1, *(1,) * (entry.ndim - 1))
    return weight
