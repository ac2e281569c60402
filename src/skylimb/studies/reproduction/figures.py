"""The reproduction's pictures: numbers beside the paper's, claims, and what moves what."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from skylimb.analysis.figures import style
from skylimb.analysis.scores.registry import SCORES
from skylimb.studies.campaign.frozen import Campaign
from skylimb.studies.campaign.rows import OK, Row
from skylimb.studies.reproduction.report import rate_text
from skylimb.studies.reproduction.result import BESIDE, HIGH, LOW, NUMBERS, READINGS, Number, Result
from skylimb.studies.reproduction.sensitivity import beyond_chance

_SHORT = {
    "error_u_median": "|y error|",
    "displacement_median": "|x displacement|",
    "estimated_force_median": "force in x",
    "error_v_median": "|z error|",
}


@style.styled
def numbers_figure(campaign: Campaign, rows: Mapping[int, Row], result: Result) -> Figure:
    """Every flight that finished, the interval and median over them, and the paper's number."""
    keys = (*NUMBERS, *BESIDE)
    colours = [style.CONTROLLER_COLOURS[name] for name in campaign.names]
    figure, panels = style.sheet(2.9, 1, len(keys))
    scatter = np.random.default_rng(0)
    numbers = {(number.controller, number.key): number for number in result.numbers}
    for ax, key in zip(panels, keys, strict=True):
        for place, name in enumerate(campaign.names):
            number = numbers[name, key]
            colour = style.CONTROLLER_COLOURS[name]
            for mark, value in (("o", "none"), ("^", "velocity")):
                points = [
                    row[key]
                    for row in rows.values()
                    if (row["controller"], row["status"], row.get(READINGS[0], "none")) == (name, OK, value)
                ]
                across = place + scatter.uniform(-0.3, 0.3, len(points))
                ax.plot(across, points, mark, color=colour, markersize=1.7, alpha=0.45, linewidth=0)
            ax.plot([place, place], [number.ours.low, number.ours.high], color=style.DARK, linewidth=1.4)
            ax.plot([place - 0.18, place + 0.18], [number.ours.median] * 2, color=style.DARK, linewidth=1.6)
            if np.isfinite(number.paper):
                face = "white" if number.inside else style.FAILURE
                mark = {"color": style.DARK, "markerfacecolor": face, "markersize": 5, "zorder": 5}
                ax.plot(place + 0.3, number.paper, "D", **mark)  # pyright: ignore[reportArgumentType]
        ax.set_title(_SHORT[key], fontsize=7.5)
        ax.set_ylabel(SCORES[key].unit)
        labels = [style.label(name) for name in campaign.names]
        ax.set_xticks(range(len(labels)), labels, rotation=35, ha="right")
        _crop(ax, [n for n in result.numbers if n.key == key])
    style.legend_below(
        figure,
        [
            style.in_colours(colours, "positions sent", marker="o", markersize=3, linestyle=""),
            style.in_colours(colours, "velocities sent", marker="^", markersize=3, linestyle=""),
            Line2D([], [], color=style.DARK, label=f"median, {100 * LOW:.0f} to {100 * HIGH:.0f} %"),
            Line2D([], [], marker="D", color=style.DARK, markerfacecolor="w", label="paper", linestyle=""),
        ],
    )
    return figure


def _crop(ax: object, numbers: list[Number]) -> None:
    """Show the intervals and the paper's numbers with a margin; single flights may lie beyond."""
    ends = [value for n in numbers for value in (n.ours.low, n.ours.high, n.paper) if np.isfinite(value)]
    if ends:
        margin = 0.25 * (max(ends) - min(ends) or 1.0)
        low = 0.0 if min(ends) >= 0.0 else min(ends) - margin
        ax.set_ylim(low, max(ends) + margin)  # type: ignore[attr-defined]


@style.styled
def claims_figure(result: Result) -> Figure:
    """In how many draws each claim holds, with its interval."""
    count = len(result.claims)
    figure, ax = style.sheet(0.23 * count + 0.7)
    for place, judged in enumerate(result.claims):
        rate = judged.rate
        colour = "#0072B2" if rate.rate >= 0.9 else ("#8C6D00" if rate.rate >= 0.5 else "#D55E00")
        ax.barh(place, rate.rate, color=colour, alpha=0.75, height=0.62)
        ax.plot([rate.low, rate.high], [place, place], color=style.DARK, linewidth=1.1)
        ax.text(1.02, place, rate_text(rate), va="center", fontsize=7)
    ax.set_yticks(range(count), [judged.claim.name for judged in result.claims])
    ax.set(xlim=(0.0, 1.32), ylim=(count - 0.4, -0.6), xlabel="share of all draws in which it holds")
    ax.set_xticks(np.linspace(0.0, 1.0, 6))
    ax.axvline(0.9, color=style.REFERENCE, linewidth=0.7, linestyle=(0, (4, 3)))
    return figure


@style.styled
def sensitivity_figure(result: Result, unknowns: Sequence[str]) -> Figure:
    """Rank correlation of every number with these unknowns, of which at least one is needed."""
    columns = list(result.sensitivity)
    clear = beyond_chance(result.draws, "clear")
    table = np.array([[result.sensitivity[column][unknown] for column in columns] for unknown in unknowns])
    figure, ax = style.sheet(max(0.19 * len(unknowns) + 1.3, 2.4))
    image = ax.imshow(table, cmap="RdBu_r", vmin=-1.0, vmax=1.0, aspect="auto")
    for (row, column), value in np.ndenumerate(table):
        if np.isfinite(value) and abs(value) >= clear:
            text = f"{value:.2f}".replace("0.", ".").replace("-", "\u2212")
            colour = "white" if abs(value) > 0.6 else style.DARK
            ax.text(column, row, text, ha="center", va="center", fontsize=5.5, color=colour)
    ax.set_yticks(range(len(unknowns)), unknowns, fontsize=6)
    ax.set_xticks(
        range(len(columns)),
        [f"{style.label(name)} {_SHORT[key]}" for name, key in columns],
        rotation=60,
        ha="right",
        fontsize=6,
    )
    for edge in range(4, len(columns), 4):
        ax.axvline(edge - 0.5, color="white", linewidth=2.0)
    figure.colorbar(image, ax=ax, label="rank correlation", shrink=0.7, pad=0.01)
    return figure
