"""How a flight kept to the wall clock: lateness, latency and overruns, as quantiles and histograms."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from skylimb.flight.realtime.pacer import Pacer

TIMING_FILE = "timing.json"
QUANTILES = (("p50", 0.5), ("p99", 0.99), ("p99.9", 0.999), ("worst", 1.0))
EDGES_US = (0, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000, np.inf)
"""Edges of the histogram's bins, microseconds."""


@dataclass(frozen=True)
class Timing:
    """Every tick of a flight on the wall clock.

    Attributes:
        period: between two ticks, s.
        late: how late each tick began, s, (k,).
        latency: from when a tick was due until its command was ready, s, (k,).
        held: whether the tick's command was that of the tick before, (k,).
    """

    period: float
    late: np.ndarray
    latency: np.ndarray
    held: np.ndarray

    @property
    def overruns(self) -> int:
        """Ticks whose command was ready only when the next tick was due."""
        return int(np.sum(self.latency > self.period))

    @property
    def kept(self) -> bool:
        """Whether the machine kept up: no tick in a thousand overran."""
        return self.overruns <= 1e-3 * len(self.late)

    def quantiles(self) -> dict[str, dict[str, float]]:
        """Of jitter (lateness) and latency, by name of the quantile, s."""
        return {
            name: {label: float(np.quantile(values, share)) for label, share in QUANTILES}
            for name, values in (("jitter", self.late), ("latency", self.latency))
            if len(values)
        }

    def histogram(self) -> list[tuple[str, int, int]]:
        """Bins in words, with how many ticks were that late, and how many commands took that long."""
        edges = np.array(EDGES_US)
        counts = [
            np.bincount(
                np.clip(np.searchsorted(edges, 1e6 * values, side="right") - 1, 0, len(edges) - 2),
                minlength=len(edges) - 1,
            )
            for values in (self.late, self.latency)
        ]
        words = [
            f"{low:g} .. {high:g} us" if np.isfinite(high) else f"over {low:g} us"
            for low, high in pairwise(edges)
        ]
        return [(word, int(a), int(b)) for word, a, b in zip(words, *counts, strict=True)]

    def record(self, faults: Mapping[str, int], **more: Any) -> str:
        """What a flight's `timing.json` says.

        Args:
            faults: how often each was met, by name.
            more: that it says as well.
        """
        told = {"verdict": self.verdict(), "seconds": self.quantiles(), **more, "faults": dict(faults)}
        return json.dumps(told, indent=2) + "\n"

    def verdict(self) -> str:
        """One sentence: whether the machine kept up."""
        count, held = len(self.late), int(np.sum(self.held))
        what = f"{self.overruns} of {count} ticks overran their {1e3 * self.period:g} ms, {held} were held"
        if self.kept:
            return f"kept up: {what}"
        return f"this machine cannot keep {1.0 / self.period:g} Hz: {what}"


def bare_timing(period: float, count: int) -> Timing:
    """The same ticks with nothing to do in them: what the machine itself costs."""
    pacer, late, latency = Pacer(period), np.zeros(count), np.zeros(count)
    pacer.start(0.01)
    for k in range(count):
        late[k] = pacer.wait(k)
        latency[k] = pacer.elapsed()
    return Timing(period, late, latency, np.zeros(count, dtype=bool))
