"""Confidence intervals that cover at any number of draws, whatever the numbers are distributed like."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import binomtest, quantile_test, spearmanr

LEVEL = 0.95
"""Of every interval that is shown."""

_HUGE = 1e150
"""Stands for infinity while numbers are interpolated; its square does not overflow."""


class Rate(NamedTuple):
    """A success rate and its Clopper-Pearson interval."""

    successes: int
    draws: int
    rate: float
    low: float
    high: float


@functools.lru_cache(maxsize=4096)
def success_rate(successes: int, count: int, level: float = LEVEL) -> Rate:
    """The rate of successes with its exact (Clopper-Pearson) interval; 0 .. 1 where nothing was flown."""
    if count == 0:
        return Rate(0, 0, float("nan"), 0.0, 1.0)
    interval = binomtest(successes, count).proportion_ci(level, "exact")
    return Rate(successes, count, successes / count, float(interval.low), float(interval.high))


def median_interval(values: np.ndarray, level: float = LEVEL) -> tuple[float, float]:
    """The interval of a median between two of the ordered values: exact, whatever their distribution.

    Args:
        values: (n,); infinite ones are welcome.
        level: of the interval.

    Returns:
        The smallest and the largest value where they are too few for an interval of this level.
    """
    interval: Any = quantile_test(finite(values), p=0.5).confidence_interval(level)
    ends = (np.min(values), np.max(values)) if np.isnan([*interval]).any() else interval
    return unbounded(ends[0]), unbounded(ends[1])


def dominance_interval(wins: int, defeats: int, count: int, level: float = LEVEL) -> tuple[float, float]:
    """The interval of the share of draws that are won less the share that are lost.

    The exact intervals of both shares, each of a level that lets both hold together (Bonferroni).

    Args:
        wins: draws that are won.
        defeats: draws that are lost; all others are ties.
        count: of the draws.
        level: of the interval.
    """
    each = 0.5 * (1.0 + level)
    won, lost = success_rate(wins, count, each), success_rate(defeats, count, each)
    return won.low - lost.high, won.high - lost.low


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
