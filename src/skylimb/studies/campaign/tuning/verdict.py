"""Judges what a search has found, on draws that it has not seen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from skylimb.analysis.scores.score import Score
from skylimb.studies.campaign.flight_queue import FlightQueue
from skylimb.studies.campaign.frozen import Campaign
from skylimb.studies.campaign.rows import Row
from skylimb.studies.campaign.spec import Search
from skylimb.studies.campaign.statistics import Paired, compare_paired, is_success, rank
from skylimb.studies.campaign.tuning.gains import Gains
from skylimb.studies.campaign.tuning.search import Trial, costs, fly_gains


@dataclass(frozen=True)
class Tuned:
    """What the search found for one controller.

    Attributes:
        name: of the controller.
        before: its gains as they were.
        after: the best found.
        cost: of the best, over the draws of the search.
        trials: how many sets of gains were flown.
        held_out: the tuned against the untuned controller over the held-out draws, by costs.
        successes: on the held-out draws, tuned and untuned.
    """

    name: str
    before: Gains
    after: Gains
    cost: float
    trials: int
    held_out: Paired
    successes: tuple[int, int]

    @property
    def better(self) -> bool:
        """Whether the tuned controller is better on the held-out draws, beyond chance."""
        return self.held_out.better > 0


@dataclass(frozen=True)
class TuneOutcome:
    """What `tune` left in a folder.

    Attributes:
        folder: where.
        objective: the score that was made good.
        draws: how many held-out draws the verdict rests on.
        tuned: by controller; empty when Ctrl-C stopped it.
        ranks: of the tuned controllers among each other, over the held-out draws.
        flown: flights that are kept.
        total: flights that it takes at most.
    """

    folder: Path
    objective: Score
    draws: int
    tuned: dict[str, Tuned] = field(default_factory=dict)
    ranks: dict[str, int] = field(default_factory=dict)
    flown: int = 0
    total: int = 0

    @property
    def complete(self) -> bool:
        """Whether the search came to its end."""
        return bool(self.tuned)

    def lines(self) -> list[str]:
        """The verdict in words, a line a controller."""
        said = []
        for name, found in self.tuned.items():
            pair = found.held_out
            verdict = "better" if found.better else "no better than the untuned one beyond chance"
            difference = (
                f"{self.objective.sign * pair.median:+.4f}"
                if np.isfinite(pair.median)
                else "decided by losses"
            )
            said.append(
                f"{name} (rank {self.ranks[name]}): {verdict} on {self.draws} held-out draws; "
                f"{self.objective.text().lower()} {difference} {self.objective.unit}".rstrip()
                + f", better in {pair.wins}, equal in {pair.ties}, worse in {pair.defeats}"
            )
        return said


def judge(
    queue: FlightQueue, starts: Mapping[str, Gains], trials: Mapping[str, Sequence[Trial]], search: Search
) -> tuple[dict[str, Tuned], dict[str, int]]:
    """Fly tuned and untuned controllers over draws that no trial has flown.

    Returns:
        What was found for each controller, and their ranks among each other.
    """
    campaign = queue.store.campaign
    draws = range(campaign.spec.draws, campaign.spec.draws + search.held_out)
    # The cheapest trial of each, the earliest of several.
    found = {name: min(trials[name], key=lambda trial: trial.cost) for name in campaign.names}
    sets = [(name, gains, draws) for name in campaign.names for gains in (found[name].gains, starts[name])]
    flown = fly_gains(queue, sets)
    tuned, columns = {}, []
    for index, name in enumerate(campaign.names):
        after, before = flown[2 * index], flown[2 * index + 1]
        columns.append(costs(campaign, after, search))
        tuned[name] = Tuned(
            name,
            starts[name],
            found[name].gains,
            found[name].cost,
            len(trials[name]),
            compare_paired(columns[-1], costs(campaign, before, search)),
            (_successes(campaign, after), _successes(campaign, before)),
        )
    ranks = rank(np.column_stack(columns))
    return tuned, dict(zip(campaign.names, ranks, strict=True))


def _successes(campaign: Campaign, rows: Sequence[Row]) -> int:
    return sum(is_success(campaign, row) for row in rows)
