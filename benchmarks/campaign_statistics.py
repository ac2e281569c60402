"""Whether a campaign's intervals cover, and how often chance makes a ranking or a region of failure.

    python benchmarks/campaign_statistics.py

What docs/reports/campaigns.md says of them.
"""

from __future__ import annotations

import math

import numpy as np

from skylimb.studies.campaign.statistics import failure_region, rank
from skylimb.studies.campaign.statistics.intervals import dominance_interval, median_interval

TRIALS = 4000
CAMPAIGNS = 1000


def median_coverage(draws: int, rng: np.random.Generator) -> float:
    """Share of samples of a skewed distribution whose interval holds its median, 1."""
    found = (median_interval(rng.lognormal(size=draws)) for _ in range(TRIALS))
    return sum(low <= 1.0 <= high for low, high in found) / TRIALS


def dominance_coverage(draws: int, won: float, lost: float) -> float:
    """Chance that the interval holds the true dominance, over all that may come of the draws."""
    tied, covered = max(0.0, 1.0 - won - lost), 0.0
    for wins in range(draws + 1):
        for defeats in range(draws + 1 - wins):
            ties = draws - wins - defeats
            low, high = dominance_interval(wins, defeats, draws)
            if low - 1e-12 <= won - lost <= high + 1e-12:
                ways = math.comb(draws, wins) * math.comb(draws - wins, defeats)
                covered += ways * won**wins * lost**defeats * tied**ties
    return covered


def false_ranking(metrics: int, rng: np.random.Generator) -> float:
    """Share of campaigns in which some of so many independent metrics ranks four equal controllers."""
    found = (
        any(len({*rank(rng.normal(size=(50, 4)))}) > 1 for _ in range(metrics)) for _ in range(CAMPAIGNS)
    )
    return sum(found) / CAMPAIGNS


def false_region(parameters: int, draws: int, rng: np.random.Generator) -> float:
    """Share of campaigns in which parameters that do not matter have a region of failure."""
    found = 0
    for _ in range(CAMPAIGNS):
        drawn = {f"p{i}": rng.random(draws) for i in range(parameters)}
        found += failure_region(drawn, rng.random(draws) < 0.3) is not None
    return found / CAMPAIGNS


if __name__ == "__main__":
    rng = np.random.default_rng(0)
    for draws in (8, 12, 20, 50):
        print(f"median, {draws} draws: {median_coverage(draws, rng):.3f}", flush=True)
    for draws in (8, 20, 50):
        for won, lost in ((0.5, 0.5), (0.8, 0.2), (0.95, 0.05), (0.1, 0.05), (0.3, 0.1)):
            print(
                f"dominance, {draws} draws, won {won}, lost {lost}:",
                f"{dominance_coverage(draws, won, lost):.3f}",
            )
    for metrics in (1, 8):
        print(f"ranking by chance, {metrics} metrics: {false_ranking(metrics, rng):.3f}", flush=True)
    for seed in range(3):
        found = false_region(8, 200, np.random.default_rng(seed))
        print(f"region by chance, seed {seed}: {found:.3f}", flush=True)
