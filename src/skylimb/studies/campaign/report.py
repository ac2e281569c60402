"""A campaign's report: one HTML page with its pictures inside, made from the table alone."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping
from dataclasses import replace
from itertools import takewhile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from skylimb.analysis.figures import style
from skylimb.analysis.pages.pages import render_page
from skylimb.analysis.recording import LOG_FILE, Run
from skylimb.analysis.scores.axis_names import AxisNames
from skylimb.analysis.scores.score import Score, grouped
from skylimb.analysis.viewer.page import viewer_html
from skylimb.base.config import to_mapping, toml_value, value_of, write_toml
from skylimb.studies.campaign.draws import changed
from skylimb.studies.campaign.figures import report_figures
from skylimb.studies.campaign.folder import log_name
from skylimb.studies.campaign.frozen import Campaign
from skylimb.studies.campaign.points import FEW
from skylimb.studies.campaign.rows import QUARANTINED, Row, unscored
from skylimb.studies.campaign.statistics import LEVEL, Paired, fewest_draws
from skylimb.studies.campaign.statistics.sign_test import POWER
from skylimb.studies.campaign.summary import Summary
from skylimb.studies.campaign.who_wins import draws_needed_for, fails_where, shown_ranks, verdicts, within

TEMPLATE = Path(__file__).with_name("report_template.html")

_MOST_LISTED = 20
_MOST_WATCHED = 4
"""Flights that are shown again; each makes the page half a megabyte larger."""


class Cell(NamedTuple):
    """A number with its small print and its rank; 0 where the draws tell nobody apart."""

    value: str
    interval: str = ""
    rank: int = 0


def render_report(
    campaign: Campaign, rows: Mapping[int, Row], summary: Summary, kept: set[int], folder: Path
) -> str:
    """The page.

    Args:
        campaign: what was flown.
        rows: by flight.
        summary: of these rows.
        kept: flights whose log lies in the folder.
        folder: the campaign's.
    """
    scores = replace(summary.scores, units=campaign.units())
    names = scores.controllers
    score, axes, declared = campaign.spec.score, summary.axes, scores.declared
    return render_page(
        TEMPLATE,
        title=f"{campaign.experiment['name']}: {len(names)} controller{'s' * (len(names) > 1)}, "
        f"{len(scores.draws)} draw{'s' * (len(scores.draws) != 1)}",
        description=str(campaign.experiment.get("description", "")).rstrip("."),
        flights=len(rows),
        draws=len(scores.draws),
        missing=missing_flights(campaign, len(rows)),
        lost=len(summary.lost),
        quarantined=[row for row in summary.lost if row["status"] == QUARANTINED],
        unscored=unscored(rows.values()),
        refused=list(scores.refused.items())[:_MOST_LISTED],
        refused_count=len(scores.refused),
        controllers=list(zip(map(style.label, names), style.colours_of(scores.controllers), strict=True)),
        rates=rates_of(summary),
        rate_called=campaign.spec.called,
        groups=[
            (title, [(score.line(summary.axes), score.unit, medians_of(score, summary)) for score in part])
            for title, part in grouped(declared[key] for key in summary.medians).items()
        ],
        verdicts=verdicts(summary, campaign.spec.aim),
        draws_needed=draws_needed_for(summary, score),
        power=f"{100.0 * POWER:.0f} %",
        ranked=len(summary.ranks),
        false_ranking=f"{100.0 * min(1.0, (1.0 - LEVEL) * len(summary.ranks)):.0f} %",
        range_only=len(scores.draws) < fewest_draws(),
        flown=_flown(summary, score) if len(scores.draws) < FEW else [],
        pairs=_pairs(summary, campaign.spec.failure),
        signed=signed,
        regions=[
            (style.label(name), fails_where(summary, name, campaign.spec.failure))
            for name in names
        ],
        figures=report_figures(scores, score, axes),
        axes=axes,
        score=within(declared[score].text(axes)),
        score_unit=declared[score].unit,
        worst=[
            (
                row,
                _cause(row, declared[score], axes),
                command(campaign, row),
                log_name(row) * (row["flight"] in kept),
            )
            for row in summary.worst
        ],
        viewer=viewer_html(
            {
                f"{style.label(row['controller'])}, flight {row['flight']}": Run.load(
                    folder / log_name(row) / LOG_FILE
                )
                for row in [row for row in summary.worst if row["flight"] in kept][:_MOST_WATCHED]
            }
        ),
        success=[
            (within(declared[key].text(axes)), bound) for key, bound in campaign.spec.success.items()
        ],
        varied=[
            (key, scores.units.get(key), json.dumps(to_mapping(entry)))
            for key, entry in campaign.spec.vary.items()
        ],
        spec=write_toml(campaign.spec.to_mapping()),
        versions=campaign.versions,
    )  # fmt: skip


def command(campaign: Campaign, row: Row) -> str:
    """The command that flies a row's flight again, bit for bit."""
    drawn = campaign.draw(row["draw"])
    gains = campaign.gains_of(drawn, row["controller"])
    preset = changed(campaign.controllers[row["controller"]].get("preset", {}), gains)
    tables = {**campaign.experiment_of(drawn).to_mapping(), "controller": preset}
    changes: dict[str, Any] = {}
    others = {f"controller.{key}" for key in drawn.gains} - {f"controller.{key}" for key in gains}
    for key in (*campaign.spec.set, *drawn.values):
        if key in others:
            continue
        # What stands in a list is set through its whole list.
        whole = ".".join(takewhile(lambda part: not part.isdecimal(), key.split(".")))
        changes[whole] = value_of(tables, whole)
    controller = next(name for name in campaign.spec.controllers if Path(name).stem == row["controller"])
    words = [
        "skylimb",
        "run",
        campaign.spec.experiment,
        "--controller",
        controller,
        "--seed",
        str(row["seed"]),
    ]
    if campaign.spec.calibration:
        words += ["--calibration", campaign.spec.calibration]
    if changes:
        words += ["--set", *(f"{key}={toml_value(value)}" for key, value in changes.items())]
    return shlex.join(words)


def missing_flights(campaign: Campaign, flights: int) -> str:
    """What has not flown, in words; empty where all has."""
    expected = campaign.flight(campaign.spec.draws, 0)
    if flights >= expected:
        return ""
    if campaign.spec.stop is not None:
        return f"stopped by its rule, or not through yet: {expected} flights at most"
    return f"not through yet: {flights} of {expected} flights"


def rates_of(summary: Summary) -> list[Cell]:
    """The success rate of each controller."""
    ranks = shown_ranks(summary.ranks.get("success", [0] * len(summary.rates)))
    return [
        Cell(f"{100.0 * rate.rate:.1f} %", f"{100.0 * rate.low:.1f} .. {100.0 * rate.high:.1f}", place)
        if rate.draws
        else Cell("–")
        for rate, place in zip(summary.rates.values(), ranks, strict=True)
    ]


def medians_of(score: Score, summary: Summary) -> list[Cell]:
    """The median of a score over each controller's flights."""
    key = score.name
    ranks = shown_ranks(summary.ranks.get(key, [0] * len(summary.medians[key])))
    return [
        Cell(
            _number(score, middle),
            "" if np.isnan(middle) else f"{_number(score, low)} .. {_number(score, high)}",
            place,
        )
        for (middle, low, high), place in zip(summary.medians[key], ranks, strict=True)
    ]


def _number(score: Score, value: float) -> str:
    """The number; a dash for one that the controller does not have."""
    if np.isnan(value):
        return "–"
    return score.printed(value) if np.isfinite(value) else "lost"


def _flown(summary: Summary, score: str) -> list[tuple[int, list[str], list[str]]]:
    """Every draw: its number, what was drawn, and each controller's score."""
    scores = summary.scores
    values = scores.metrics.get(score, np.full(scores.finished.shape, np.nan))
    values = np.where(scores.finished, values, np.inf)  # a lost flight has no number
    lines = []
    for place, draw in enumerate(scores.draws):
        drawn = [column[place] for column in scores.parameters.values()]
        words = [f"{each:.4g}" if isinstance(each, float | np.floating) else str(each) for each in drawn]
        lines.append((int(draw), words, [_number(scores.declared[score], each) for each in values[place]]))
    return lines


def _pairs(summary: Summary, failure: str) -> list[tuple[str, str, str, Paired, str, str]]:
    lines = []
    for key, pairs in summary.paired.items():
        score = summary.scores.declared.get(key)
        label, goal = (
            (score.titled(summary.axes), score.sign) if score else (f"Share of draws with a {failure}", 1.0)
        )
        for (first, second), pair in pairs.items():
            low, high = (pair.low, pair.high) if goal > 0.0 else (-pair.high, -pair.low)
            middle, low, high = (_difference(value, goal) for value in (goal * pair.median, low, high))
            difference = f"{middle} ({low} .. {high})"
            winner = style.label(first if pair.better > 0 else second) if pair.better else ""
            lines.append((label, style.label(first), style.label(second), pair, difference, winner))
    return lines


def _difference(value: float, goal: float) -> str:
    """A difference; an infinite one is that of a lost flight, whichever way the metric is good."""
    if np.isfinite(value):
        return signed(value, 4)
    return "first lost" if value * goal > 0.0 else "second lost"


def signed(value: float, places: int = 2) -> str:
    """A number with its sign; what is zero at so many places has none, and no number is a dash."""
    if np.isnan(value):
        return "–"
    text = f"{value:+z.{places}f}".replace("-", "\N{MINUS SIGN}")
    return text if float(f"{value:.{places}f}") else text.lstrip("+")


def _cause(row: Row, score: Score, axes: AxisNames) -> str:
    if row["cause"]:
        return row["cause"]
    value, what = row[score.name], within(score.text(axes))
    return f"no {what}" if value is None else f"{what} {score.printed(value)} {score.unit}".strip()
