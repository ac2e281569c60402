"""Samples of topics, each with its own stamps, put on the ticks of one clock."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

_SAME = 0.05
"""Seconds between a message's own stamp and its recording that are no offset of a clock."""

Sample = tuple[float, float, np.ndarray]
"""When a sample was recorded, s, its own stamp, s (0 for none), and its values, (width,)."""


class Series(NamedTuple):
    """What one topic said over time.

    Attributes:
        times: on the recorder's clock, s, (n,).
        offset: that was taken off the messages' own stamps, s.
        values: (n, width).
    """

    times: np.ndarray
    offset: float
    values: np.ndarray

    def at(self, ticks: np.ndarray) -> np.ndarray:
        """The last sample at or before each tick, (k, width); the first one before any."""
        order = np.argsort(self.times, kind="stable")
        rows = np.searchsorted(self.times[order], ticks + 1e-9, side="right") - 1
        return self.values[order][np.maximum(rows, 0)]


def series_of(samples: Sequence[Sample]) -> Series | None:
    """Samples of one topic on the recorder's clock; None where they differ in size.

    A message's own stamp is better than the time of its recording, which a network delays. Where the two
    clocks differ, the median of the difference is taken off the stamps.
    """
    if len({values.shape for _, _, values in samples}) > 1:
        return None
    recorded, stamped = np.array([sample[:2] for sample in samples]).T
    values = np.array([sample[2] for sample in samples])
    if not (stamped > 0.0).all():
        return Series(recorded, 0.0, values)
    offset = float(np.median(stamped - recorded))
    offset = offset if abs(offset) > _SAME else 0.0
    return Series(stamped - offset, offset, values)
