"""Whether draws tell two controllers apart, and about how many draws would."""

from __future__ import annotations

import math

import numpy as np
from scipy.stats import binomtest, norm

from skylimb.studies.campaign.statistics.intervals import LEVEL

POWER = 0.8
"""With which the suggested number of draws finds a difference as large as the one seen."""


def better(first: np.ndarray, second: np.ndarray, level: float = LEVEL) -> int:
    """Which of two controllers is better beyond chance: 1 the first, -1 the second, 0 nobody can tell.

    By the exact two-sided sign test: of the draws that are not equal, each would go to either with
    probability 1/2 were they alike. It holds for any number of draws.

    Args:
        first: costs of each draw, smaller is better, a loss is infinite, (n,).
        second: of the other in the same draws, (n,).
        level: one less the share of equal pairs that are called different.
    """
    wins, defeats = int(np.sum(first < second)), int(np.sum(first > second))
    if wins == defeats or binomtest(wins, wins + defeats).pvalue >= 1.0 - level:
        return 0
    return 1 if wins > defeats else -1


def fewest_draws(level: float = LEVEL) -> int:
    """The fewest draws that can tell anything: all of them won by one, 2 (1/2)^n < 1 - level."""
    return math.floor(1.0 - math.log2(1.0 - level)) + 1


def draws_needed(first: np.ndarray, second: np.ndarray, level: float = LEVEL) -> float:
    """About how many draws would tell two controllers apart if they differ as these draws show.

    Noether's formula for the sign test, n = (z_(1 - a/2) + z_power)^2 / (4 (p - 1/2)^2) with a = 1 - level,
    over the share of draws that are not equal. The probability p that the better one wins a draw comes from
    the spread: the normal distribution's value at mean over standard deviation of the differences. Where a
    flight was lost or nothing spreads it is the share of draws won, by Laplace's rule.

    Args:
        first: costs of each draw, smaller is better, a loss is infinite, (n,).
        second: of the other in the same draws, (n,).
        level: see `better`.

    Returns:
        A whole number, at least `fewest_draws`; infinite where the draws show no difference.
    """
    wins, defeats = int(np.sum(first < second)), int(np.sum(first > second))
    decided = wins + defeats
    if not decided:
        return math.inf
    probability = (max(wins, defeats) + 1.0) / (decided + 2.0)
    if np.isfinite(first).all() and np.isfinite(second).all() and decided > 1:
        difference = first - second
        spread = float(np.std(difference, ddof=1))
        if spread > 0.0:
            probability = float(norm.cdf(abs(float(np.mean(difference))) / spread))
    if probability - 0.5 < 1e-9:
        return math.inf
    both = norm.ppf(0.5 + 0.5 * level) + norm.ppf(POWER)
    count = float(both**2 / (4.0 * (probability - 0.5) ** 2)) * len(first) / decided
    return float(max(math.ceil(count), fewest_draws(level)))
