"""Confidence intervals: exact ones for rates, bootstrap ones for everything else."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import binomtest, bootstrap, spearmanr

LEVEL = 0.95
"""Of every interval that is shown."""

RESAMPLES = 2000

_HUGE = 1e150
"""Stands for infinity while numbers are interpolated; its square does not overflow."""


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


def bootstrap_interval(
    statistic: Callable[..., np.ndarray], values: np.ndarray, seed: int, level: float = LEVEL
) -> tuple[float, float]:
    """The percentile bootstrap interval of a statistic.

    Args:
        statistic: `np.mean` or `np.median`.
        values: (n,); infinite ones are welcome where the statistic can bear huge ones in their place.
        seed: of the resampling. All intervals of a campaign have one, so that they rest on the same samples.
        level: of the interval.
    """
    if len(values) < 2:
        return float(statistic(values)), float(statistic(values))
    found: Any = bootstrap(
        (finite(values),),
        statistic,
        n_resamples=RESAMPLES,
        confidence_level=level,
        method="percentile",
        rng=np.random.default_rng([seed, 2]),
    )
    low, high = found.confidence_interval
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


def rank_correlation(first: np.ndarray, second: np.ndarray) -> float:
    """Spearman's rank correlation; NaN where one of them is constant, or there are fewer than three."""
    if len(first) < 3 or np.ptp(first) == 0.0 or np.ptp(second) == 0.0:
        return float("nan")
    found: Any = spearmanr(first, second)
    return float(found.statistic)
