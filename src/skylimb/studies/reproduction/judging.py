"""Work out what a finished ensemble says of the paper."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping

import numpy as np

from skylimb.analysis.paper.claims import CLAIMS, PaperClaim
from skylimb.analysis.paper.numbers import PUBLISHED, published
from skylimb.studies.campaign.frozen import Campaign
from skylimb.studies.campaign.rows import OK, REFUSED, Row
from skylimb.studies.campaign.statistics import refusal, success_rate
from skylimb.studies.reproduction.prior import Prior
from skylimb.studies.reproduction.result import (
    BESIDE,
    HIGH,
    LOW,
    NUMBERS,
    READINGS,
    Judged,
    Near,
    Number,
    Ratio,
    Result,
    Spread,
)
from skylimb.studies.reproduction.sensitivity import correlations, unknown_columns

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

_PRINTED = {name: vars(numbers) for name, numbers in PUBLISHED.items()}

NEAREST = 8
"""Draws that are listed, nearest to the paper's table first."""


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
        {index: cause for index, group in enumerate(draws) if (cause := refusal(group.values()))},
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
    values, known = _column(draws, name, key), published(name, key)
    paper = np.nan if known is None else known
    by = {value: _spread(values[np.array(read_as) == value]) for value in sorted(set(read_as)) if value}
    return Number(name, key, paper, *_beside(values, paper), by)


def _ratio(draws: list[dict[str, Row]], key: str, first: str, second: str) -> Ratio:
    paper = getattr(PUBLISHED[first], key) / getattr(PUBLISHED[second], key)
    below = _column(draws, second, key)
    values = _column(draws, first, key) / np.where(below == 0.0, np.nan, below)
    return Ratio(key, first, second, paper, *_beside(values, paper))


def _beside(values: np.ndarray, paper: float) -> tuple[Spread, float, bool]:
    """Ours beside the paper's number: the share of ours below it, %, and whether our interval has it."""
    ours, there = _spread(values), values[np.isfinite(values)]
    percentile = float("nan")
    if len(there) and np.isfinite(paper):  # equal ones count half
        percentile = 100.0 * float(np.mean((there < paper) + 0.5 * (there == paper)))
    return ours, percentile, bool(ours.low <= paper <= ours.high)


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
        # Whether it is true of the twelve printed numbers.
        claim.holds(_PRINTED) if set(claim.keys) <= set(NUMBERS) else None,
        {value: success_rate(sum(some), len(some)) for value, some in by.items()},
    )


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
