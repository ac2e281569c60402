"""Ranks that admit when the draws cannot tell two controllers apart."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from skylimb.studies.campaign.statistics.intervals import LEVEL
from skylimb.studies.campaign.statistics.sign_test import better


def rank(costs: np.ndarray, level: float = LEVEL) -> list[int]:
    """Ranks of the controllers, from 1; equal ranks are ties.

    One controller beats another where an exact sign test tells them apart. Its level is raised for the number
    of pairs (Bonferroni), so that with `level` no controller beats an equal one. A rank is one more than the
    number of controllers that beat it.

    Args:
        costs: (n, controllers), smaller is better, a loss is infinite.
        level: for all comparisons together.
    """
    count = costs.shape[1]
    beaten = [0] * count
    for a, b in combinations(range(count), 2):
        verdict = better(costs[:, a], costs[:, b], level_of_pair(count, level))
        beaten[b] += verdict > 0
        beaten[a] += verdict < 0
    return [1 + number for number in beaten]


def level_of_pair(controllers: int, level: float = LEVEL) -> float:
    """The level of one comparison of two, so that all comparisons together have `level`."""
    pairs = controllers * (controllers - 1) // 2
    return 1.0 - (1.0 - level) / max(pairs, 1)
