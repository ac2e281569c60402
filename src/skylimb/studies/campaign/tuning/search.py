"""The search: CMA-ES over a campaign's draws, the same number of trials for every controller."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from skylimb.studies.campaign.flight_queue import FlightQueue
from skylimb.studies.campaign.frozen import Campaign
from skylimb.studies.campaign.rows import Row
from skylimb.studies.campaign.spec import Search
from skylimb.studies.campaign.statistics import is_success
from skylimb.studies.campaign.tuning.gains import Gains, from_point, to_point
from skylimb.studies.campaign.worker import Job

_LOSS = 1e6
"""What a flight without success adds to a trial's cost: more than any metric can."""


class Trial(NamedTuple):
    """A set of gains that was flown over the draws.

    Attributes:
        controller: name.
        number: in the order of the search, the controller's own gains being 0.
        cost: losses first, then the median of the objective.
        gains: what was flown.
    """

    controller: str
    number: int
    cost: float
    gains: Gains


def search_gains(strategies: Any, queue: FlightQueue, name: str, start: Gains, search: Search) -> list[Trial]:
    """Every trial of a controller, the first being its own gains.

    The points follow from the seed and from what was flown, so that an interrupted search, begun again over
    the flights that it has kept, goes on as if nothing had happened.

    Args:
        strategies: the module `cma`.
        queue: flies.
        name: of the controller.
        start: its own gains.
        search: what is searched.
    """
    campaign = queue.store.campaign
    spec, draws = campaign.spec, range(campaign.spec.draws)
    options = {"bounds": [0.0, 1.0], "seed": spec.seed + 1, "verbose": -9, "maxfevals": search.trials}
    strategy = strategies.CMAEvolutionStrategy(to_point(start, search), search.spread, options)
    first = fly_gains(queue, [(name, start, draws)])[0]
    trials = [Trial(name, 0, cost(campaign, first, search), start)]
    while len(trials) < search.trials and not strategy.stop():
        points = strategy.ask()
        tried = [from_point(point, search) for point in points[: search.trials - len(trials)]]
        flown = fly_gains(queue, [(name, gains, draws) for gains in tried])
        found = [cost(campaign, rows, search) for rows in flown]
        for gains, value in zip(tried, found, strict=True):
            trials.append(Trial(name, len(trials), value, gains))
        if len(tried) < len(points):  # the budget ends within a generation, which then teaches nothing more
            break
        strategy.tell(points, found)
    return trials


def fly_gains(queue: FlightQueue, sets: Sequence[tuple[str, Gains, range]]) -> list[list[Row]]:
    """The rows of each controller with some gains over some draws; what the store holds is not flown again.

    Args:
        queue: flies.
        sets: controller, gains and draws of each.
    """
    campaign, rows = queue.store.campaign, queue.store.rows
    jobs = [
        [
            Job(campaign.flight(draw, campaign.names.index(name)), tuple(sorted(gains.items())))
            for draw in draws
        ]
        for name, gains, draws in sets
    ]
    # Equal jobs, the same gains in two places, fly once.
    queue.fly([job for job in dict.fromkeys(chain(*jobs)) if job.key not in rows])
    return [[rows[job.key] for job in each] for each in jobs]


def cost(campaign: Campaign, rows: Sequence[Row], search: Search) -> float:
    """Losses first, then the median of the objective over the successes."""
    values = costs(campaign, rows, search)
    good = values[np.isfinite(values)]
    return _LOSS * (len(rows) - len(good)) + (float(np.median(good)) if len(good) else 0.0)


def costs(campaign: Campaign, rows: Sequence[Row], search: Search) -> np.ndarray:
    """The objective of each row, smaller is better; infinite where the flight was no success."""
    values = [row[search.objective] if is_success(campaign, row) else None for row in rows]
    sign = campaign.spec.scores[search.objective].sign
    return np.array([np.inf if value is None else sign * value for value in values])
