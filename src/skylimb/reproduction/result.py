"""What an ensemble says of the paper: its numbers, its claims, and which unknown moves what."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.stats import rankdata

from skylimb.analysis.measures import describe
from skylimb.analysis.paper_claims import CLAIMS, PaperClaim
from skylimb.analysis.paper_numbers import PUBLISHED, published
from skylimb.campaign.frozen import Campaign
from skylimb.campaign.rows import OK, REFUSED, Row, parameters
from skylimb.campaign.statistics import Rate, success_rate
from skylimb.reproduction.prior import Prior

LOW, HIGH = 0.05, 0.95
"""Quantiles of the interval that a published number is held against."""

NUMBERS = ("error_y_median", "displacement_x_median", "estimated_force_x_median")
"""The paper's twelve, four controllers each."""
BESIDE = ("error_z_median",)
"""What it shows in a box plot without a number."""

SPLIT_BY = "trajectory.feedforward"
"""The unknown whose values are also shown apart: it changes the task itself."""

NEAREST = 8


class Spread(NamedTuple):
    """Median and interval of some flights that finished."""

    flights: int
    median: float
    low: float
    high: float


class Number(NamedTuple):
    """One number of the table.

    Attributes:
        controller: whose.
        key: metric.
        paper: the paper's number; NaN where it prints none.
        ours: over all flights that finished.
        percentile: share of those flights below the paper's number, %; equal ones count half.
        inside: whether the paper's number lies within the interval.
        split: the same by the value of `SPLIT_BY`.
    """

    controller: str
    key: str
    paper: float
    ours: Spread
    percentile: float
    inside: bool
    split: dict[str, Spread]


class Judged(NamedTuple):
    """A claim, held against every draw.

    Attributes:
        claim: what.
        rate: share of all draws in which it holds; a draw that loses a flight it needs is one in which it does
            not.
        finished: the same among the draws that lost none of those flights.
        paper: whether it is true of the paper's own printed numbers; None where they don't tell.
    """

    claim: PaperClaim
    rate: Rate
    finished: Rate
    paper: bool | None


class Near(NamedTuple):
    """A draw that comes near the paper's table."""

    draw: int
    distance: float
    values: dict[str, dict[str, float]]
    parameters: dict[str, object]


@dataclass(frozen=True)
class Result:
    """An ensemble's result.

    Attributes:
        draws: flown.
        flights: flown.
        numbers: the twelve, and those beside them.
        ratios: hybrid over impedance and admittance over PID of the displacement: (paper's, ours).
        claims: in the paper's order.
        failures: controller -> cause -> flights.
        refused: draws that nobody can fly -> cause; they count as lost in every claim.
        sensitivity: (controller, key) -> unknown -> rank correlation.
        nearest: draws, nearest first.
    """

    draws: int
    flights: int
    numbers: list[Number]
    ratios: dict[str, tuple[float, Spread]]
    claims: list[Judged]
    failures: dict[str, dict[str, int]]
    refused: dict[int, str]
    sensitivity: dict[tuple[str, str], dict[str, float]]
    nearest: list[Near]

    @property
    def inside(self) -> int:
        """How many of the published numbers lie in their interval."""
        return sum(number.inside for number in self.numbers if np.isfinite(number.paper))


def judge(prior: Prior, campaign: Campaign, rows: Mapping[int, Row]) -> Result:
    """Work out the result from a finished ensemble's table."""
    names = campaign.names
    draws = [
        {name: rows[campaign.flight(index, c)] for c, name in enumerate(names)}
        for index in range(campaign.spec.draws)
    ]
    columns = unknown_columns(campaign, len(draws))
    return Result(
        len(draws),
        len(rows),
        [_number(draws, name, key) for key in (*NUMBERS, *BESIDE) for name in names],
        {
            f"{first} / {second}": _ratio(draws, first, second)
            for first, second in (("hybrid", "impedance"), ("admittance", "pid"))
        },
        [_judge(claim, draws) for claim in CLAIMS.values()],
        _failures(draws),
        {
            index: group[names[0]]["cause"]
            for index, group in enumerate(draws)
            if any(row["status"] == REFUSED for row in group.values())
        },
        {
            (name, key): _correlations(columns, _column(draws, name, key))
            for key in (*NUMBERS, *BESIDE)
            for name in names
        },
        _nearest(prior, campaign, draws),
    )


def unknown_columns(campaign: Campaign, draws: int) -> dict[str, np.ndarray]:
    """Every unknown as a column of numbers, (draws,).

    Entries of a list stand apart, unless one factor scales them all. A choice of two is 0 or 1. An angle on the
    circle enters as the place where the lap starts, across and up.
    """
    table = [parameters(campaign, campaign.draw(index)) for index in range(draws)]
    columns: dict[str, np.ndarray] = {}
    for name in table[0]:
        values = [row[name] for row in table]
        key, _, entry = name.rpartition(".")
        if entry.isdigit() and campaign.spec.vary[key].times:
            if entry == "0":
                columns[key] = np.array(values) / campaign.spec.vary[key].times[0]
            continue
        if name.endswith("start_angle"):
            angles = np.array(values)
            columns[f"{name}, across"] = np.round(np.cos(angles), 9)
            columns[f"{name}, up"] = np.round(np.sin(angles), 9)
        elif isinstance(values[0], str):
            known = sorted(set(values))
            columns[name] = np.array([float(known.index(value)) for value in values])
        else:
            columns[name] = np.array([float(value) for value in values])
    return columns


def _column(draws: list[dict[str, Row]], name: str, key: str) -> np.ndarray:
    """A number of one controller over the draws; NaN for a loss."""
    return np.array(
        [np.nan if draw[name]["status"] != OK or draw[name][key] is None else draw[name][key] for draw in draws],
        dtype=float,
    )


def _spread(values: np.ndarray) -> Spread:
    values = values[np.isfinite(values)]
    if not len(values):
        return Spread(0, np.nan, np.nan, np.nan)
    low, middle, high = np.quantile(values, [LOW, 0.5, HIGH])
    return Spread(len(values), float(middle), float(low), float(high))


def _number(draws: list[dict[str, Row]], name: str, key: str) -> Number:
    values = _column(draws, name, key)
    ours = _spread(values)
    known = published(name, key)
    paper = np.nan if known is None else known
    there = values[np.isfinite(values)]
    below = np.mean((there < paper) + 0.5 * (there == paper)) if len(there) else np.nan
    branches = np.array([str(draw[name].get(SPLIT_BY, "")) for draw in draws])
    return Number(
        name,
        key,
        paper,
        ours,
        100.0 * float(below) if np.isfinite(paper) else np.nan,
        bool(ours.low <= paper <= ours.high),
        {value: _spread(values[branches == value]) for value in sorted(set(branches)) if value},
    )


def _ratio(draws: list[dict[str, Row]], first: str, second: str) -> tuple[float, Spread]:
    key = "displacement_x_median"
    printed = getattr(PUBLISHED[first], key) / getattr(PUBLISHED[second], key)
    return printed, _spread(_column(draws, first, key) / _column(draws, second, key))


def _judge(claim: PaperClaim, draws: list[dict[str, Row]]) -> Judged:
    told = [
        draw
        for draw in draws
        if all(draw[name]["status"] == OK for name in claim.controllers)
        and all(draw[name][key] is not None for name in claim.controllers for key in claim.keys)
    ]
    holds = sum(claim.holds(draw) for draw in told)
    return Judged(claim, success_rate(holds, len(draws)), success_rate(holds, len(told)), _printed(claim))


def _printed(claim: PaperClaim) -> bool | None:
    """Whether the claim is true of the twelve printed numbers."""
    if not set(claim.keys) <= set(NUMBERS):
        return None
    return claim.holds({name: vars(numbers) for name, numbers in PUBLISHED.items()})


def _failures(draws: list[dict[str, Row]]) -> dict[str, dict[str, int]]:
    """Losses by their cause, without the moment at which each happened."""
    found: dict[str, Counter[str]] = {}
    for draw in draws:
        for name, row in draw.items():
            count = found.setdefault(name, Counter())
            if row["status"] not in (OK, REFUSED):
                count[re.sub(r" at t = [\d.]+ s$", "", row["cause"])] += 1
    return {name: dict(sorted(count.items())) for name, count in found.items()}


def _correlations(columns: Mapping[str, np.ndarray], values: np.ndarray) -> dict[str, float]:
    """Spearman's rank correlation of a number with every unknown, over the flights that finished."""
    there = np.isfinite(values)
    return {name: _rank_correlation(column[there], values[there]) for name, column in columns.items()}


def _rank_correlation(first: np.ndarray, second: np.ndarray) -> float:
    if len(first) < 3 or np.ptp(first) == 0.0 or np.ptp(second) == 0.0:
        return float("nan")
    return float(np.corrcoef(rankdata(first), rankdata(second))[0, 1])


def _nearest(prior: Prior, campaign: Campaign, draws: list[dict[str, Row]]) -> list[Near]:
    """The draws nearest to the paper's table: root mean square over the twelve, in standard deviations."""
    names = [name for name in campaign.names if name in PUBLISHED]
    table = np.array([[_column(draws, name, key) for name in names] for key in NUMBERS])
    paper = np.array([[getattr(PUBLISHED[name], key) for name in names] for key in NUMBERS])
    complete = np.isfinite(table).all(axis=(0, 1))
    if np.count_nonzero(complete) < 2:
        return []
    scale = table[:, :, complete].std(axis=2)
    away = np.sqrt(np.mean(((table - paper[..., None]) / scale[..., None]) ** 2, axis=(0, 1)))
    order = [int(i) for i in np.argsort(np.where(complete, away, np.inf), kind="stable") if complete[i]]
    return [
        Near(
            index,
            float(away[index]),
            {name: {key: float(draws[index][name][key]) for key in NUMBERS} for name in names},
            {unknown.key: campaign.draw(index).values[unknown.key] for unknown in prior.unknowns},
        )
        for index in order[:NEAREST]
    ]


def label(key: str) -> str:
    """How a number is called in a table, with its unit."""
    text, unit = describe(key)
    return text if unit == "1" else f"{text}, {unit}"
