"""The picture of a campaign of few draws: every flight as a point that bears its draw's number."""

from __future__ import annotations

from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from skylimb.analysis.figures import style
from skylimb.analysis.scores.axis_names import AxisNames
from skylimb.studies.campaign.panels import add_legend, panels
from skylimb.studies.campaign.statistics import Scores

FEW = 8
"""Below this many draws a campaign shows its flights one by one: a distribution of so few says nothing."""


@style.styled
def points(scores: Scores, names: AxisNames) -> Figure:
    """Every flight's value of each metric that controllers are ranked by, a panel a metric.

    A grey line joins the flights of one draw and ends with its number. A cross beyond the worst of the values
    is a lost flight.
    """
    figure, axes = panels(scores.ranked, 2.2)
    for key, ax in axes.items():
        _panel(ax, scores, key, names)
    draw = Line2D([], [], color=style.TRUTH, linewidth=0.7, label="one draw, with its number")
    lost = Line2D([], [], color=style.FAILURE, marker="x", linestyle="", markersize=4.5, label="lost flight")
    add_legend(figure, scores, draw, *([] if scores.finished.all() else [lost]))
    return figure


def _panel(ax: Axes, scores: Scores, key: str, names: AxisNames) -> None:
    values, places = scores.metrics[key], np.arange(len(scores.controllers))
    there = scores.finished & np.isfinite(values)
    low, high = style.limits([values[there]], 0.12)
    worst = (
        high if scores.declared[key].sign > 0.0 else low
    )  # a lost flight stands beyond all that have a value
    drawn = np.where(there, values, np.where(scores.finished, np.nan, worst))
    ends: list[tuple[float, int]] = []
    for draw, row in zip(scores.draws, drawn, strict=True):
        ax.plot(places, row, color=style.TRUTH, linewidth=0.7, zorder=1)
        if np.isfinite(row[-1]):
            ends.append((float(row[-1]), int(draw)))
    for place, colour in zip(places, style.colours_of(scores.controllers), strict=True):
        column, lost = values[there[:, place], place], ~scores.finished[:, place]
        ax.scatter(np.full(len(column), place), column, s=16, color=colour, zorder=3)
        beyond = np.full(lost.sum(), worst)
        ax.scatter(np.full(len(beyond), place), beyond, s=20, marker="x", color=style.FAILURE, zorder=3)
    for height, text in _apart(ends, 0.07 * (high - low)):
        ax.text(places[-1] + 0.12, height, text, fontsize=6.5, va="center", color=style.DARK)
    ax.set_ylabel(fill(scores.declared[key].titled(names), 30), fontsize=7)
    room = 0.08 * (high - low)
    ax.set(xlim=(-0.4, places[-1] + 0.6), ylim=(low - room, high + room))
    labels = [style.label(name) for name in scores.controllers]
    ax.set_xticks(places, labels, rotation=30, ha="right", rotation_mode="anchor", fontsize=6.5)
    ax.yaxis.set_major_locator(MaxNLocator(4))


def _apart(ends: list[tuple[float, int]], least: float) -> list[tuple[float, str]]:
    """Heights of the draws' numbers: those nearer to each other than `least` share a place."""
    groups: list[list[tuple[float, int]]] = []
    for end in sorted(ends):
        if groups and end[0] - groups[-1][0][0] < least:
            groups[-1].append(end)
        else:
            groups.append([end])
    return [
        (
            float(np.mean([height for height, _ in group])),
            ", ".join(str(d) for d in sorted(d for _, d in group)),
        )
        for group in groups
    ]
