"""A campaign's numbers in one place: what summary.json holds and the report prints."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from skylimb.analysis.scores.axis_names import GENERIC, AxisNames, names_of_vectors
from skylimb.control.missions.frame import contact_frame
from skylimb.studies.campaign.frozen import FORMAT_VERSION, Campaign
from skylimb.studies.campaign.logs import worst
from skylimb.studies.campaign.rows import BROKEN_OFF, LOST, QUARANTINED, Row
from skylimb.studies.campaign.statistics import (
    LEVEL,
    Paired,
    Rate,
    Region,
    Scores,
    compare_paired,
    failure_region,
    rank,
    scores_of,
    success_rate,
)
from skylimb.studies.campaign.statistics.intervals import median, median_interval

WORST = 10


@dataclass(frozen=True)
class Summary:
    """What a campaign says.

    Attributes:
        scores: the flights as arrays.
        rates: success rate of each controller.
        medians: metric -> (median, low, high) of each controller; losses count as infinitely bad.
        paired: metric or "success" -> (first, second) -> their comparison.
        ranks: metric or "success" -> rank of each controller.
        regions: where each controller fails, or None.
        worst: rows of the worst flights.
        lost: rows of all lost flights.
        axes: what the task's axes are called.
    """

    scores: Scores
    rates: dict[str, Rate]
    medians: dict[str, list[tuple[float, float, float]]]
    paired: dict[str, dict[tuple[str, str], Paired]]
    ranks: dict[str, list[int]]
    regions: dict[str, Region | None]
    worst: list[Row]
    lost: list[Row]
    axes: AxisNames


def summarize(campaign: Campaign, rows: Mapping[int, Row]) -> Summary:
    """Work out everything that the report shows, from the table alone."""
    scores = scores_of(campaign, rows)
    names, count = scores.controllers, len(scores.draws)
    compared = ["success", *scores.ranked] if count else []
    costs = {key: scores.cost(key) for key in compared}
    return Summary(
        scores=scores,
        rates={name: success_rate(int(scores.success[:, i].sum()), count) for i, name in enumerate(names)},
        medians={key: medians(scores, key) for key in scores.metrics} if count else {},
        paired={
            key: {
                (names[a], names[b]): compare_paired(values[:, a], values[:, b])
                for a, b in combinations(range(len(names)), 2)
            }
            for key, values in costs.items()
        },
        ranks={key: rank(values) for key, values in costs.items()},
        regions={
            name: failure_region(scores.parameters, ~scores.success[:, i]) if count else None
            for i, name in enumerate(names)
        },
        worst=worst(campaign, rows.values(), WORST),
        lost=[rows[flight] for flight in sorted(rows) if rows[flight]["status"] in LOST],
        axes=_axes(campaign),
    )


def _axes(campaign: Campaign) -> AxisNames:
    """What the axes are called in every draw; u, v and n where draws differ in the contact axis."""
    if any(key.startswith("contact_axis") for key in campaign.spec.vary):
        return GENERIC
    frame = contact_frame(campaign.experiment_of(campaign.draw(0)).contact_axis)
    return names_of_vectors(frame.sliding_u, frame.sliding_v, frame.contact)


def medians(scores: Scores, key: str) -> list[tuple[float, float, float]]:
    """Medians with their intervals; a loss enters as the bad end of the metric.

    A controller that finishes and never has the number (such as an error to a target that its law does not
    have) has no median, NaN. What a flight does or does not, such as being done as commanded, has its rate
    over all draws in place of a median.
    """
    score = scores.declared[key]
    if score.kind == "yes or no":
        kept = scores.finished & (scores.metrics[key] == 1.0)
        rates = [success_rate(int(count), len(scores.draws)) for count in kept.sum(axis=0)]
        return [(rate.rate, rate.low, rate.high) for rate in rates]
    found = []
    for index, column in enumerate(scores.cost(key).T):
        if scores.finished[:, index].any() and np.isnan(scores.metrics[key][:, index]).all():
            found.append((np.nan, np.nan, np.nan))
            continue
        low, high = median_interval(column)
        low, high = (low, high) if score.sign > 0.0 else (-high, -low)
        found.append((score.sign * median(column), low, high))
    return found


def summary_json(campaign: Campaign, rows: Mapping[int, Row], summary: Summary) -> str:
    """The summary as JSON text; infinite numbers are the strings "inf" and "-inf"."""
    scores = summary.scores
    names = scores.controllers
    ended = {name: [row["status"] for row in rows.values() if row["controller"] == name] for name in names}
    content = {
        "format": FORMAT_VERSION,
        "experiment": campaign.spec.experiment,
        "draws": len(scores.draws) + len(scores.refused),
        "flights": len(rows),
        "interval_level": LEVEL,
        "controllers": {
            name: {
                "success": summary.rates[name]._asdict(),
                "lost": sum(status in BROKEN_OFF for status in ended[name]),
                "quarantined": ended[name].count(QUARANTINED),
                "median": {
                    key: dict(zip(("median", "low", "high"), values[i], strict=True))
                    for key, values in summary.medians.items()
                },
                "rank": {key: ranks[i] for key, ranks in summary.ranks.items()},
                "fails_where": _region(summary.regions[name]),
            }
            for i, name in enumerate(names)
        },
        "paired": {
            key: [{"first": a, "second": b, **pair._asdict()} for (a, b), pair in pairs.items()]
            for key, pairs in summary.paired.items()
        },
        "worst_flights": [row["flight"] for row in summary.worst],
        "quarantined_flights": [row["flight"] for row in summary.lost if row["status"] == QUARANTINED],
        "refused_draws": {str(index): cause for index, cause in scores.refused.items()},
        "versions": campaign.versions,
    }
    return json_text(content)


def _region(region: Region | None) -> dict[str, Any] | None:
    if region is None:
        return None
    return {**region._asdict(), "conditions": [str(condition) for condition in region.conditions]}


def json_text(content: Any, indent: int = 2, digits: int = 17) -> str:
    """JSON of numbers as NumPy has them: NaN is null, infinite ones are the strings "inf" and "-inf".

    Args:
        content: mappings, sequences and numbers.
        indent: of each level.
        digits: significant ones; 17 give every bit.
    """

    def plain(node: Any) -> Any:
        if isinstance(node, dict):
            return {key: plain(value) for key, value in node.items()}
        if isinstance(node, list | tuple):
            return [plain(value) for value in node]
        node = node.item() if isinstance(node, np.generic) else node
        if not isinstance(node, float):
            return node
        if math.isfinite(node):
            return float(f"{node:.{digits}g}")
        return None if math.isnan(node) else f"{node:g}"

    return json.dumps(plain(content), indent=indent, allow_nan=False) + "\n"
