"""Two controllers over the same draws."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from skylimb.studies.campaign.statistics.intervals import dominance_interval, median, median_interval
from skylimb.studies.campaign.statistics.sign_test import better, draws_needed


class Paired(NamedTuple):
    """The first controller against the second, draw by draw.

    Attributes:
        median: of the differences first less second; infinite where losses decide it.
        low: end of its interval.
        high: end of its interval.
        wins: draws in which the first is better.
        ties: draws in which they are equal; both lost is equal.
        defeats: draws in which the second is better.
        dominance: (wins - defeats) / draws, from -1 to 1: an effect size that losses enter as they are.
        dominance_low: end of its interval.
        dominance_high: end of its interval.
        standardized: mean over standard deviation of the differences, over the draws that both finished; NaN
            where there are fewer than two or they are all equal.
        both_finished: how many draws that is.
        better: 1 where the first is better beyond chance, -1 where the second is, 0 where nobody can tell.
        draws_to_tell: about how many draws would tell them apart; infinite where they show no difference.
    """

    median: float
    low: float
    high: float
    wins: int
    ties: int
    defeats: int
    dominance: float
    dominance_low: float
    dominance_high: float
    standardized: float
    both_finished: int
    better: int
    draws_to_tell: float


def compare_paired(first: np.ndarray, second: np.ndarray) -> Paired:
    """Compare two controllers' costs (smaller is better, a loss is infinite) over paired draws.

    Args:
        first: (n,).
        second: (n,).
    """
    difference = np.zeros(len(first))
    np.subtract(first, second, out=difference, where=first != second)
    sign = np.sign(-difference)
    wins, ties, defeats = (int(np.sum(sign == value)) for value in (1.0, 0.0, -1.0))
    both = difference[np.isfinite(first) & np.isfinite(second)]
    spread = float(np.std(both, ddof=1)) if len(both) > 1 else 0.0
    return Paired(
        median(difference), *median_interval(difference),
        wins, ties, defeats,
        float(np.mean(sign)), *dominance_interval(wins, defeats, len(sign)),
        float(np.mean(both)) / spread if spread > 0.0 else float("nan"), len(both),
        better(first, second), draws_needed(first, second),
    )  # fmt: skip
