"""What an ensemble says of the paper: its numbers, its claims, and which unknown moves what."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from skylimb.analysis.axis_names import PAPER
from skylimb.analysis.measures import describe
from skylimb.analysis.paper_claims import CLAIMS, PaperClaim
from skylimb.analysis.paper_numbers import PUBLISHED, published
from skylimb.campaign.frozen import Campaign
from skylimb.campaign.rows import OK, REFUSED, Row
from skylimb.campaign.statistics import Rate, success_rate
from skylimb.reproduction.prior import Prior
from skylimb.reproduction.sensitivity import correlations, unknown_columns

LOW, HIGH = 0.05, 0.95
"""Quantiles of the interval that a published number is held against."""

NUMBERS = ("error_u_median", "displacement_median", "estimated_force_median")
"""The paper's twelve, four controllers each."""
BESIDE = ("error_v_median",)
"""What it shows in a box plot without a number."""

RATIOS = (
    ("error_u_median", "impedance", "pid"),
    ("error_u_median", "hybrid", "admittance"),
    ("displacement_median", "hybrid", "impedance"),
    ("displacement_median", "admittance", "pid"),
    ("estimated_force_median", "impedance", "pid"),
    ("estimated_force_median", "admittance", "pid"),
    ("estimated_force_median", "hybrid", "impedance"),
)
"""What the choice of one law for the other changes, within a draw."""

READINGS = ("trajectory.feedforward", "controller.estimation.tare")
"""Unknowns whose values are also shown apart.

They are no tolerances but readings of the paper: what was sent, and what was fed back. That these two were
worth setting apart was seen in the sensitivities; the prior weighs their values alike.
"""

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
        split: the same by reading.
    """

    controller: str
    key: str
    paper: float
    ours: Spread
    percentile: float
    inside: bool
    split: dict[str, Spread]


class Ratio(NamedTuple):
    """One controller's number over another's in the same draw.

    The single numbers move together with the unknowns, so a table may lie inside every interval and still
    hold a ratio that no draw shows.
    """

    key: str
    first: str
    second: str
    paper: float
    ours: Spread
    percentile: float
    inside: bool


class Judged(NamedTuple):
    """A claim, held against every draw.

    Attributes:
        claim: what.
        rate: share of all draws in which it holds; where a flight is lost that it needs, it does not.
        finished: the same among the draws that lost none of those flights.
        paper: whether it is true of the paper's own printed numbers; None where they don't tell.
        split: the rate of all draws by reading.
    """

    claim: PaperClaim
    rate: Rate
    finished: Rate
    paper: bool | None
    split: dict[str, Rate]


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
        ratios: of two controllers' numbers, `RATIOS`.
        claims: in the paper's order.
        failures: controller -> cause -> flights.
        refused: draws that nobody can fly -> cause; they count as lost in every claim.
        sensitivity: (controller, key) -> unknown -> rank correlation.
        nearest: draws, nearest first.
    """

    draws: int
    flights: int
    numbers: list[Number]
    ratios: list[Ratio]
    claims: list[Judged]
    failures: dict[str, dict[str, int]]
    refused: dict[int, str]
    sensitivity: dict[tuple[str, str], dict[str, float]]
    nearest: list[Near]

    @property
    def inside(self) -> int:
        """How many of the published numbers lie in their interval."""
        return sum(number.inside for number in self.numbers if np.isfinite(number.paper))


def reading(campaign: Campaign, index: int) -> str:
    """The reading of the paper that a draw flies, in words; empty where the prior leaves none open."""
    values = campaign.draw(index).values
    words = {
        "trajectory.feedforward": {"none": "positions sent", "velocity": "velocities sent"},
        "controller.estimation.tare": {True: "estimate tared", False: "raw estimate"},
    }
    return ", ".join(words[key].get(values[key], str(values[key])) for key in READINGS if key in values)


def judge(prior: Prior, campaign: Campaign, rows: Mapping[int, Row]) -> Result:
    """Work out the result from a finished ensemble's table."""
    names = campaign.names
    draws = [
        {name: rows[campaign.flight(index, c)] for c, name in enumerate(names)}
        for index in range(campaign.spec.draws)
    ]
    read_as = [reading(campaign, index) for index in range(len(draws))]
    columns = unknown_columns(campaign, len(draws))
    return Result(
        len(draws),
        len(rows),
        [_number(draws, read_as, name, key) for key in (*NUMBERS, *BESIDE) for name in names],
        [_ratio(draws, *ratio) for ratio in RATIOS],
        [_judge(claim, draws, read_as) for claim in CLAIMS.values()],
        _failures(draws),
        {
            index: group[names[0]]["cause"]
            for index, group in enumerate(draws)
            if any(row["status"] == REFUSED for row in group.values())
        },
        {
            (name, key): correlations(columns, _column(draws, name, key))
            for key in (*NUMBERS, *BESIDE)
            for name in names
        },
        _nearest(prior, campaign, draws),
    )


def _column(draws: list[dict[str, Row]], name: str, key: str) -> np.ndarray:
    """A number of one controller over the draws; NaN for a loss."""
    rows = [draw[name] for draw in draws]
    return np.array(
        [row[key] if row["status"] == OK and row[key] is not None else np.nan for row in rows], dtype=float
    )


def _spread(values: np.ndarray) -> Spread:
    values = values[np.isfinite(values)]
    if not len(values):
        return Spread(0, np.nan, np.nan, np.nan)
    low, middle, high = np.quantile(values, [LOW, 0.5, HIGH])
    return Spread(len(values), float(middle), float(low), float(high))


def _number(draws: list[dict[str, Row]], read_as: list[str], name: str, key: str) -> Number:
    values = _column(draws, name, key)
    ours = _spread(values)
    known = published(name, key)
    paper = np.nan if known is None else known
    readings = np.array(read_as)
    return Number(
        name,
        key,
        paper,
        ours,
        _percentile(values, paper),
        bool(ours.low <= paper <= ours.high),
        {value: _spread(values[readings == value]) for value in sorted(set(read_as)) if value},
    )


def _ratio(draws: list[dict[str, Row]], key: str, first: str, second: str) -> Ratio:
    paper = getattr(PUBLISHED[first], key) / getattr(PUBLISHED[second], key)
    below = _column(draws, second, key)
    values = _column(draws, first, key) / np.where(below == 0.0, np.nan, below)
    ours = _spread(values)
    return Ratio(
        key, first, second, paper, ours, _percentile(values, paper), bool(ours.low <= paper <= ours.high)
    )


def _percentile(values: np.ndarray, number: float) -> float:
    """Share of the values below a number, %; equal ones count half."""
    there = values[np.isfinite(values)]
    if not len(there) or not np.isfinite(number):
        return float("nan")
    return 100.0 * float(np.mean((there < number) + 0.5 * (there == number)))


def _judge(claim: PaperClaim, draws: list[dict[str, Row]], read_as: list[str]) -> Judged:
    tells = [
        all(draw[name]["status"] == OK for name in claim.controllers)
        and all(draw[name][key] is not None for name in claim.controllers for key in claim.keys)
        for draw in draws
    ]
    holds = [tell and claim.holds(draw) for tell, draw in zip(tells, draws, strict=True)]
    by = {
        value: [hold for hold, other in zip(holds, read_as, strict=True) if other == value]
        for value in sorted(set(read_as))
        if value
    }
    return Judged(
        claim,
        success_rate(sum(holds), len(draws)),
        success_rate(sum(holds), sum(tells)),
        _printed(claim),
        {value: success_rate(sum(some), len(some)) for value, some in by.items()},
    )


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


def _nearest(prior: Prior, campaign: Campaign, draws: list[dict[str, Row]]) -> list[Near]:
    """The draws nearest to the paper's table: root mean square over the twelve, in standard deviations."""
    names = [name for name in campaign.names if name in PUBLISHED]
    table = np.array([[_column(draws, name, key) for name in names] for key in NUMBERS])
    paper = np.array([[getattr(PUBLISHED[name], key) for name in names] for key in NUMBERS])
    complete = np.isfinite(table).all(axis=(0, 1))
    if np.count_nonzero(complete) < 2:
        return []
    scale = table[:, :, complete].std(axis=2)
    scale = np.where(scale > 0.0, scale, 1.0)
    away = np.sqrt(np.mean(((table - paper[..., None]) / scale[..., None]) ** 2, axis=(0, 1)))
    order = np.argsort(np.where(complete, away, np.inf), kind="stable")[: np.count_nonzero(complete)].tolist()
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
    text, unit = describe(key, PAPER)
    return text if unit == "1" else f"{text}, {unit}"
