"""What an ensemble says of the paper: its numbers, its claims, and which unknown moves what."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from skylimb.analysis.paper.claims import PaperClaim
from skylimb.analysis.scores.axis_names import PAPER
from skylimb.analysis.scores.registry import SCORES
from skylimb.studies.campaign.statistics import Rate

LOW, HIGH = 0.05, 0.95
"""Quantiles of the interval that a published number is held against."""

NUMBERS = ("error_u_median", "displacement_median", "estimated_force_median")
"""The paper's twelve, four controllers each."""
BESIDE = ("error_v_median",)
"""What it shows in a box plot without a number."""

READINGS = ("trajectory.feedforward", "controller.estimation.tare")
"""Unknowns whose values are also shown apart.

They are no tolerances but readings of the paper: what was sent, and what was fed back. That these two were
worth setting apart was seen in the sensitivities; the prior weighs their values alike.
"""


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
        ratios: of two controllers' numbers, those of `judging.RATIOS`.
        claims: in the paper's order.
        failures: controller -> cause -> flights.
        refused: draws that some controller cannot fly -> cause; they count as lost in every claim.
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


def label(key: str) -> str:
    """How a number is called in a table, with its unit."""
    return ", ".join(filter(None, (SCORES[key].text(PAPER), SCORES[key].unit)))
