"""The report's pictures: how each metric is distributed, and what it depends on."""

from __future__ import annotations

import base64
from textwrap import fill
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from skylimb.analysis.figures import style
from skylimb.analysis.scores.axis_names import AxisNames
from skylimb.studies.campaign.maps import CLEAR_WIN, failure_map, has_cells, winner_map
from skylimb.studies.campaign.panels import add_legend, panels
from skylimb.studies.campaign.points import FEW, points
from skylimb.studies.campaign.statistics import Scores, parameters_by_information
from skylimb.studies.campaign.statistics.intervals import finite, rank_correlation

_MOST_PARAMETERS = 4
_CURVE_BINS = 8
_IN_BIN = 5
"""Flights that a median along a parameter rests on, at least, where the parameter is no grid."""
_MANY = 60
"""Draws from which on their dots are small and pale."""

_PROFILES = (
    "Share of all draws in which a controller was at least as good as the value below. A lost flight is "
    "never good enough: a curve that ends below 1 has lost the rest. Higher and further left is better: the "
    "axis runs from right to left where large values are good."
)
_POINTS = (
    "Every flight's numbers, a point a flight. A grey line joins the flights of one draw and ends with its "
    "number. Controllers are compared along these lines. So few draws have no distribution worth a curve."
)
_TRENDS = (
    "{} over the parameters that matter most: every flight, and where there are enough, the median of those "
    "that finished along the parameter. Crosses at the top are lost flights."
)
_FAILURES = (
    "Every flight at its place: dots succeeded, crosses did not. The shade is the share of failures among "
    "the nearest draws."
)
_WINNERS = (
    "The controller with the best {} in at least {:.0f} % of a cell's draws; grey cells have no clear "
    "winner. A lost flight wins nothing."
)


class ReportFigure(NamedTuple):
    """A figure with its words; `source` is the picture itself, as a data URL."""

    name: str
    title: str
    caption: str
    source: str


def report_figures(scores: Scores, score: str, axes: AxisNames) -> list[ReportFigure]:
    """Every picture that the flights allow for."""
    if not scores.ranked:
        return []  # nobody finished
    if len(scores.draws) < FEW:
        return [_finished("points", "Every flight", _POINTS, points(scores, axes))]
    if score not in scores.metrics:
        return []
    label = scores.declared[score].text(axes)
    made = [_finished("profiles", "How good, how often", _PROFILES, profiles(scores, axes))]
    ordered = [name for name in by_influence(scores, score) if scores.parameters[name].dtype.kind in "fi"]
    shown = [name for name in ordered if len(set(scores.parameters[name])) > 1]
    if shown:
        figure = trends(scores, score, shown[:_MOST_PARAMETERS], axes)
        made.append(_finished("trends", "What it depends on", _TRENDS.format(label), figure))
    if len(shown) > 1 and not scores.success.all():
        figure = failure_map(scores, shown[0], shown[1])
        made.append(_finished("failures", "Where each controller fails", _FAILURES, figure))
    if len(shown) > 1 and len(scores.controllers) > 1 and has_cells(scores, shown[0], shown[1]):
        figure = winner_map(scores, score, shown[0], shown[1])
        words = _WINNERS.format(label[:1].lower() + label[1:], 100.0 * CLEAR_WIN)
        made.append(_finished("winners", "Who wins where", words, figure))
    return made


def by_influence(scores: Scores, score: str) -> list[str]:
    """Parameters by how much they tell: about failures where there are some, else about the score."""
    failed = ~scores.success
    if failed.any() and not failed.all():
        return parameters_by_information(scores.parameters, failed)

    def strength(name: str) -> float:
        values = scores.parameters[name]
        if values.dtype.kind not in "fi":
            return 0.0
        # A symmetric valley says as much as a slope: the distance from the middle counts, too.
        both = (values, np.abs(values - np.median(values)))
        found = [rank_correlation(x, finite(column)) for column in scores.cost(score).T for x in both]
        return float(np.nanmax(np.abs([0.0, *found])))

    return sorted(scores.parameters, key=lambda name: -strength(name))


@style.styled
def profiles(scores: Scores, axes_names: AxisNames) -> Figure:
    """The distribution of each metric that controllers are ranked by, a curve a controller."""
    figure, axes = panels(scores.ranked, 1.75)
    for key, ax in axes.items():
        score = scores.declared[key]
        for column, colour in zip(scores.cost(key).T, style.colours_of(scores.controllers), strict=True):
            finished = score.sign * np.sort(column[np.isfinite(column)])
            share = np.arange(1, len(finished) + 1) / len(column)
            ax.step(finished, share, where="post", color=colour)
        ax.set_xlabel(fill(score.titled(axes_names), 30), fontsize=7)
        ax.set_ylim(0.0, 1.02)
        if score.sign < 0.0:
            ax.invert_xaxis()
    figure.axes[0].set_ylabel("share of draws")
    add_legend(figure, scores)
    return figure


@style.styled
def trends(scores: Scores, score: str, parameters: list[str], axes_names: AxisNames) -> Figure:
    """The score of every flight over some parameters, with medians along them."""
    figure, (axes,) = style.sheet(2.6, 1, len(parameters), squeeze=False, sharey=True)
    values, colours = scores.metrics[score], style.colours_of(scores.controllers)
    bottom, top = style.limits([values[scores.finished]], 0.08)
    dots = {"s": 4, "alpha": 0.35} if len(scores.draws) > _MANY else {"s": 14, "alpha": 0.8}
    for ax, parameter in zip(axes, parameters, strict=True):
        x = scores.parameters[parameter].astype(float)
        for column, flown, colour in zip(values.T, scores.finished.T, colours, strict=True):
            ax.scatter(x[flown], column[flown], color=colour, linewidths=0, **dots)
            at_top = np.full((~flown).sum(), top)
            ax.scatter(x[~flown], at_top, s=12, marker="x", color=colour, linewidths=0.8)
            ax.plot(*_running_median(x[flown], column[flown]), color=colour)
        ax.set_xlabel(scores.called(parameter).replace(".", ".\n", 1))
        ax.locator_params(axis="x", nbins=4)
        ax.set_ylim(bottom, top + 0.03 * (top - bottom))
    axes[0].set_ylabel(fill(scores.declared[score].titled(axes_names), 26))
    add_legend(figure, scores)
    return figure


def _running_median(x: np.ndarray, y: np.ndarray) -> tuple[list[float], list[float]]:
    """Medians along a parameter: at each value of a grid, else of groups of neighbours; empty for too few."""
    distinct, bins = np.unique(x), min(_CURVE_BINS, len(x) // _IN_BIN)
    if len(distinct) <= _CURVE_BINS:
        groups = [x == value for value in distinct]
    elif bins > 1:
        parts = np.array_split(np.argsort(x, kind="stable"), bins)
        groups = [np.isin(np.arange(len(x)), part) for part in parts]
    else:
        return [], []
    return [float(np.median(x[group])) for group in groups], [float(np.median(y[group])) for group in groups]


def _finished(name: str, title: str, caption: str, figure: Figure) -> ReportFigure:
    source = f"data:image/png;base64,{base64.b64encode(style.png(figure, 170)).decode('ascii')}"
    return ReportFigure(name, title, caption, source)
