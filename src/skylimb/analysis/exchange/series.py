"""Samples of topics, each with its own stamps, put on the ticks of one clock."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

_SAME = 0.05
"""Seconds between a message's own stamp and its recording that are no offset of a clock."""


@dataclass
class Series:
    """What one topic said over time.

    Attributes:
        recorded: when each sample was recorded, s.
        stamped: its own stamp, s; NaN where it has none.
        values: the samples.
    """

    recorded: list[float] = field(default_factory=list)
    stamped: list[float] = field(default_factory=list)
    values: list[np.ndarray] = field(default_factory=list)

    def add(self, recorded: float, stamped: float, value: np.ndarray) -> None:
        """One sample more."""
        self.recorded.append(recorded)
        self.stamped.append(stamped if stamped > 0.0 else np.nan)
        self.values.append(np.asarray(value, dtype=float))

    @property
    def usable(self) -> bool:
        """Whether there are samples, all of one size."""
        return bool(self.values) and len({value.shape for value in self.values}) == 1

    def times(self) -> tuple[np.ndarray, float]:
        """Times on the recorder's clock, rising, and the offset of the stamps that was taken off, s.

        A message's own stamp is better than the time of its recording, which a network delays. Where the two
        clocks differ, the median of the difference is taken off the stamps.
        """
        recorded, stamped = np.array(self.recorded), np.array(self.stamped)
        if not np.isfinite(stamped).all():
            return recorded, 0.0
        offset = float(np.median(stamped - recorded))
        offset = offset if abs(offset) > _SAME else 0.0
        return stamped - offset, offset

    def at(self, ticks: np.ndarray, times: np.ndarray) -> np.ndarray:
        """The last sample at or before each tick, (k, width); the first one before any."""
        order = np.argsort(times, kind="stable")
        rows = np.searchsorted(times[order], ticks + 1e-9, side="right") - 1
        return np.array(self.values)[order][np.maximum(rows, 0)]
