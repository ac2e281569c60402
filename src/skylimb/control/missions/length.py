"""How long a flight may be: what it records has to fit into memory."""

from __future__ import annotations

import math

from skylimb.base.errors import ConfigError

MOST_TICKS = 500_000
"""Ticks of a flight at most: 42 minutes at 200 Hz, longer than any battery lasts."""

_BYTES = 4_000
"""Memory that a tick takes, with its rows, its log and a copy of it; measured."""


def tick_count(duration: float, period: float, what: str = "the mission") -> int:
    """Ticks in `duration` s, both ends counted, with one every `period` s.

    Args:
        duration: s.
        period: s.
        what: what lasts so long, for the error.

    Raises:
        ConfigError: when they are more than `MOST_TICKS`; nothing has been allocated for them then.
    """
    ticks = duration / period
    if not math.isfinite(ticks) or round(ticks) + 1 > MOST_TICKS:
        raise ConfigError(
            f"{what} would last {duration:.4g} s, {ticks:.4g} ticks of {period:g} s and some "
            f"{1e-9 * _BYTES * ticks:.3g} GB of log; a flight has {MOST_TICKS} ticks at most, here "
            f"{MOST_TICKS * period:g} s"
        )
    return round(ticks) + 1
