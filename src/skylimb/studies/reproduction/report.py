"""The report: one HTML page with its pictures inside."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

from skylimb.analysis.figures import style
from skylimb.analysis.pages.pages import inlined, render_page
from skylimb.analysis.paper.numbers import SOURCE
from skylimb.analysis.scores.registry import SCORES
from skylimb.studies.campaign.frozen import Campaign
from skylimb.studies.campaign.statistics import Rate
from skylimb.studies.reproduction.files import command
from skylimb.studies.reproduction.otherwise import flown_otherwise
from skylimb.studies.reproduction.prior import Prior, value_text
from skylimb.studies.reproduction.result import BESIDE, HIGH, LOW, NUMBERS, Result, Spread, label

TEMPLATE = Path(__file__).with_name("report_template.html")

CAPTIONS = {
    "numbers": (
        "The published numbers among the draws",
        "Medians over the sliding period, the errors to the mission's reference. Every flight that "
        "finished, with median and interval, beside the paper's number (diamond; filled "
        "red where it lies outside). Single flights beyond the axes are not shown.",
    ),
    "claims": (
        "How often the claims hold",
        "In how many of the draws each claim holds, with its exact 95 % interval. A draw that lost a flight "
        "is one in which the claim does not hold.",
    ),
    "sensitivity": (
        "What moves what",
        "Spearman's rank correlation of each number with each unknown, over the flights that finished; "
        "printed where it is clear of chance. Bars around a name: the distance from its middle. What shows "
        "in no number is left out here, and is in reproduction.json.",
    ),
    "errata": (
        "The printed forms",
        "What each printed form does, beside the corrected one. A cross marks a lost flight.",
    ),
}
"""Title and words of each figure."""


def render_report(prior: Prior, campaign: Campaign, result: Result, pictures: Mapping[str, Path]) -> str:
    """The page.

    Args:
        prior: what was drawn from.
        campaign: the ensemble.
        result: of it.
        pictures: figure's name -> PNG file.
    """
    return render_page(
        TEMPLATE,
        {"rate": rate_text, "spread": spread_text, "label": label},
        title=f"The paper held against {result.draws} draws",
        result=result,
        readings=list(result.claims[0].split),
        total=sum(math.isfinite(number.paper) for number in result.numbers),
        lost=sum(sum(causes.values()) for causes in result.failures.values()),
        low=100 * LOW,
        high=100 * HIGH,
        names=[(name, style.label(name), style.CONTROLLER_COLOURS[name]) for name in campaign.names],
        numbers=[
            (label(key), digits(key), [n for n in result.numbers if n.key == key])
            for key in (*NUMBERS, *BESIDE)
        ],
        nearest=[
            (near, [(unknown.key, value_text(near.parameters[unknown.key])) for unknown in prior.unknowns])
            for near in result.nearest
        ],
        keys=[(key, digits(key), SCORES[key].unit) for key in NUMBERS],
        prior=prior,
        otherwise=flown_otherwise(prior, campaign),
        shown="sensitivity" in pictures,
        pictures=[(name, *CAPTIONS[name], inlined(path, "image/png")) for name, path in pictures.items()],
        command=command(result.draws),
        source=SOURCE,
        versions=campaign.versions,
    )


def digits(key: str) -> int:
    """Digits behind the point: lengths to a millimetre; a force needs no more than two."""
    return 2 if SCORES[key].unit == "N" else 3


def spread_text(spread: Spread, places: int) -> str:
    """Median and interval."""
    if not spread.flights:
        return "none finished"
    return f"{spread.median:.{places}f} ({spread.low:.{places}f} .. {spread.high:.{places}f})"


def rate_text(rate: Rate) -> str:
    """A share with its interval, %."""
    if not rate.draws:
        return "no draw"
    return f"{100 * rate.rate:.0f} % ({100 * rate.low:.0f} .. {100 * rate.high:.0f})"
