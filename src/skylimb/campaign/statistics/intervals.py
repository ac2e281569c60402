"""Confidence intervals: exact ones for rates, bootstrap ones for everything else."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.stats import binomtest

LEVEL = 0.95
"""Of every interval that is shown."""

RESAMPLES = 2000

_HUGE = 1e300
"""Stands for infinity while numbers are interpolated; the sum of two doesn't overflow."""


class Rate(NamedTuple):
    """A success rate and its Clopper-Pearson interval."""

    successes: int
    draws: int
    rate: float
    low: float
    high: float


def success_rate(successes: int, count: int, level: float = LEVEL) -> Rate:
    """The rate of successes with its exact (Clopper-Pearson) interval; 0 .. 1 where nothing was flown."""
    if count == 0:
        return Rate(0, 0, float("nan"), 0.0, 1.0)
    interval = binomtest(successes, count).proportion_ci(level, "exact")
    return Rate(successes, count, successes / count, float(interval.low), float(interval.high))


def bootstrap_rows(count: int, seed: int, resamples: int = RESAMPLES) -> np.ndarray:
    """Rows drawn with replacement, (resamples, count): one set serves all figures, so that they agree."""
    return np.random.default_rng([seed, 2]).integers(0, count, (resamples, count))


def bootstrap_interval(
    statistic: Callable[[np.ndarray], np.ndarray],
    values: np.ndarray,
    rows: np.ndarray,
    level: float = LEVEL,
) -> tuple[float, float]:
    """The percentile bootstrap interval of a statistic.

    Args:
        statistic: reduces the last axis, (..., n) -> (...).
        values: (n,); infinite ones are welcome where the statistic can bear 1e300 in their place.
        rows: as `bootstrap_rows` gives them.
        level: of the interval.
    """
    resampled = statistic(finite(values)[rows])
    low, high = np.quantile(resampled, [(1.0 - level) / 2.0, (1.0 + level) / 2.0])
    return unbounded(low), unbounded(high)


def median(values: np.ndarray) -> float:
    """The median of numbers some of which are infinite."""
    return unbounded(np.median(finite(values)))


def finite(values: np.ndarray) -> np.ndarray:
    """The values with huge numbers in place of infinite ones."""
    return np.clip(values, -_HUGE, _HUGE)


def unbounded(value: float | np.floating) -> float:
    """A number back from `finite`: anything that a huge one went into is infinite."""
    return float(np.copysign(np.inf, value)) if abs(value) > _HUGE * 1e-6 else float(value)
