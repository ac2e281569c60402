"""Ranks that admit when the draws cannot tell two controllers apart."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from skylimb.campaign.statistics.intervals import LEVEL
from skylimb.campaign.statistics.paired import dominance_interval


def rank(badness: np.ndarray, seed: int, level: float = LEVEL) -> list[int]:
    """Ranks of the controllers, from 1; equal ranks are ties.

    One controller beats another where the interval of their dominance excludes zero. The intervals are
    widened for the number of pairs (Bonferroni), so that with `level` no controller beats an equal one. A
    rank is one more than the number of controllers that beat it.

    Args:
        badness: (n, controllers), smaller is better, a loss is infinite.
        seed: of the intervals.
        level: for all comparisons together.
    """
    count = badness.shape[1]
    pairs = list(combinations(range(count), 2))
    beaten = [0] * count
    for a, b in pairs:
        widened = 1.0 - (1.0 - level) / len(pairs)
        low, high = dominance_interval(badness[:, a], badness[:, b], seed, widened)
        beaten[b] += low > 0.0
        beaten[a] += high < 0.0
    return [1 + number for number in beaten]
