"""A table of flights as arrays: draws by controllers, smaller is better, a loss is infinitely bad."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from skylimb.analysis.scores.registry import SCORES
from skylimb.analysis.scores.score import Score
from skylimb.studies.campaign.frozen import Campaign
from skylimb.studies.campaign.rows import FINISHED, REFUSED, Row, parameter_names


@dataclass(frozen=True)
class Scores:
    """The flights of all draws that every controller has flown.

    Attributes:
        controllers: names, in the campaign's order.
        draws: indices, (n,).
        success: whether each flight is one, (n, controllers).
        finished: whether each flight came to its end, (n, controllers).
        metrics: name -> values, NaN where there is none, (n, controllers).
        parameters: name -> what was drawn, (n,).
        refused: draws that some controller cannot fly, with the cause; they are in none of the arrays.
        declared: what each metric is, by name.
        units: of the parameters that have one, by name.
    """

    controllers: tuple[str, ...]
    draws: np.ndarray
    success: np.ndarray
    finished: np.ndarray
    metrics: dict[str, np.ndarray]
    parameters: dict[str, np.ndarray]
    refused: dict[int, str]
    declared: Mapping[str, Score] = field(default_factory=lambda: SCORES)
    units: Mapping[str, str] = field(default_factory=dict)

    @property
    def ranked(self) -> list[str]:
        """The metrics by which controllers are compared, of those that any flight has."""
        return [
            key
            for key, each in self.declared.items()
            if each.directed and each.ranked and key in self.metrics
        ]

    def called(self, parameter: str) -> str:
        """A parameter with its unit, as figures call it."""
        unit = self.units.get(parameter)
        return f"{parameter} ({unit})" if unit else parameter

    def cost(self, name: str) -> np.ndarray:
        """What is compared, (n, controllers): a metric by its goal, infinite for a loss; "success" is 0."""
        if name == "success":
            return 1.0 - self.success
        values = self.declared[name].sign * self.metrics[name]
        return np.where(self.finished & np.isfinite(values), values, np.inf)


def scores_of(campaign: Campaign, rows: Mapping[int, Row], draws: int | None = None) -> Scores:
    """Gather the draws that are complete; of the first `draws` only, where that is given."""
    count = len(campaign.names)
    last = campaign.spec.draws if draws is None else draws
    complete = [
        [rows[campaign.flight(index, c)] for c in range(count)]
        for index in range(last)
        if all(campaign.flight(index, c) in rows for c in range(count))
    ]
    refused = {group[0]["draw"]: cause for group in complete if (cause := refusal(group))}
    flown = [group for group in complete if group[0]["draw"] not in refused]

    def table(value: Callable[[Row], Any], kind: type) -> np.ndarray:
        """A value of every flight, (n, controllers)."""
        return np.array([[value(row) for row in group] for group in flown], dtype=kind).reshape(-1, count)

    # None, a number that a flight does not have, becomes NaN; an older folder lacks some of today's scores.
    metrics = {key: table(lambda row, key=key: row.get(key), float) for key in campaign.spec.keys}
    return Scores(
        campaign.names,
        np.array([group[0]["draw"] for group in flown], dtype=int),
        table(lambda row: is_success(campaign, row), bool),
        table(lambda row: row["status"] in FINISHED, bool),
        {key: values for key, values in metrics.items() if np.isfinite(values).any()},
        {name: np.array([group[0][name] for group in flown]) for name in parameter_names(campaign)},
        refused,
        campaign.spec.scores,
    )


def refusal(group: Collection[Row]) -> str:
    """Why a draw cannot be flown, and by whom where others can; empty where everybody can.

    Args:
        group: the row of each controller.
    """
    refusing = [row for row in group if row["status"] == REFUSED]
    if not refusing:
        return ""
    names = ", ".join(row["controller"] for row in refusing)
    return refusing[0]["cause"] if len(refusing) == len(group) else f"{names}: {refusing[0]['cause']}"


def is_success(campaign: Campaign, row: Row) -> bool:
    """Whether a flight finished and kept every bound of the spec's `success`."""
    if row["status"] not in FINISHED:
        return False
    return all(
        row[key] is not None
        and (bound.min is None or row[key] >= bound.min)
        and (bound.max is None or row[key] <= bound.max)
        for key, bound in campaign.spec.success.items()
    )
