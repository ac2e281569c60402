"""The report's maps over two parameters: where each controller fails, and who wins."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from skylimb.analysis.figures import style
from skylimb.studies.campaign.panels import add_legend, colours_of, panels
from skylimb.studies.campaign.statistics import Scores

CLEAR_WIN = 0.6
"""Share of a cell's draws that a controller must win for the cell to have its colour."""

_CELLS = 7
"""Cells along a parameter, at most. A grid of no more values has a cell for each."""

_IN_CELL = 8
"""Draws that a cell has on average, at least, where the parameters are no grid."""


@style.styled
def failure_map(scores: Scores, first: str, second: str) -> Figure:
    """Successes and failures over two parameters, a panel a controller."""
    figure, axes = panels(scores.controllers, 1.9, (first, second))
    x, y = (scores.parameters[name].astype(float) for name in (first, second))
    image: Any = None
    for (name, ax), failed in zip(axes.items(), ~scores.success.T, strict=True):
        image = ax.pcolormesh(
            *_failure_share(x, y, failed), cmap="Reds", vmin=0.0, vmax=1.0, alpha=0.75, linewidth=0
        )
        ax.scatter(x[~failed], y[~failed], s=3, color=style.TRUTH, linewidths=0)
        ax.scatter(x[failed], y[failed], s=10, marker="x", color=style.FAILURE, linewidths=0.8)
        ax.set_title(f"{style.label(name)}\n{failed.sum()} of {len(failed)} failed")
    figure.colorbar(image, ax=figure.axes, shrink=0.8, pad=0.01, label="share of failures")
    return figure


@style.styled
def winner_map(scores: Scores, score: str, first: str, second: str) -> Figure:
    """The controller that wins most of the draws in each cell of two parameters; see `has_cells`."""
    figure = Figure((0.62 * style.WIDTH, 3.0), layout="constrained")
    ax = figure.subplots()
    values = scores.cost(score)
    best = np.where(np.isfinite(values.min(axis=1)), np.argmin(values, axis=1), -1)
    x, y = (scores.parameters[name].astype(float) for name in (first, second))
    edges_x, edges_y = _edges(x, _cells(len(x))), _edges(y, _cells(len(y)))
    for low, high in pairwise(edges_x):
        for below, above in pairwise(edges_y):
            inside = best[(x >= low) & (x <= high) & (y >= below) & (y <= above)]
            _cell(ax, (low, below, high - low, above - below), inside, colours_of(scores))
    ax.set(xlim=edges_x[[0, -1]], ylim=edges_y[[0, -1]], xlabel=first, ylabel=second)
    add_legend(figure, scores)
    return figure


def _cell(
    ax: Axes, place: tuple[float, float, float, float], winners: np.ndarray, colours: list[str]
) -> None:
    if not len(winners):
        return
    wins = [int(np.sum(winners == index)) for index in range(len(colours))]
    clear = max(wins) >= CLEAR_WIN * len(winners)
    colour = colours[int(np.argmax(wins))] if clear else "#C8CCD2"
    ax.add_patch(
        Rectangle(place[:2], *place[2:], facecolor=colour, alpha=0.8, edgecolor="white", linewidth=0.8)
    )
    middle = (place[0] + place[2] / 2.0, place[1] + place[3] / 2.0)
    ax.text(*middle, str(len(winners)), ha="center", va="center", fontsize=6, color="white")


def has_cells(scores: Scores, first: str, second: str) -> bool:
    """Whether there are enough draws for cells over two parameters that each say something."""
    gridded = all(len(set(scores.parameters[name])) <= _CELLS for name in (first, second))
    return gridded or _cells(len(scores.draws)) > 1


def _cells(draws: int) -> int:
    """Cells along each of two parameters, so that a cell has `_IN_CELL` draws."""
    return min(_CELLS, int((draws / _IN_CELL) ** 0.5))


def _edges(values: np.ndarray, cells: int = _CELLS) -> np.ndarray:
    distinct = np.unique(values)
    if len(distinct) <= _CELLS:  # a grid: cells around its values
        middles = (distinct[1:] + distinct[:-1]) / 2.0
        pad = (distinct[1] - distinct[0]) / 2.0
        return np.concatenate([[distinct[0] - pad], middles, [distinct[-1] + pad]])
    return np.linspace(values.min(), values.max(), max(cells, 1) + 1)


def _failure_share(
    x: np.ndarray, y: np.ndarray, failed: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Share of failures among the draws nearest to each cell of a fine mesh.

    Values of a grid are no neighbours of each other: along one, only draws of the same value are near.
    """
    edges, scales = [], []
    for values in (x, y):
        gridded = len(np.unique(values)) <= _CELLS
        pad = 0.04 * np.ptp(values)
        edges.append(_edges(values) if gridded else np.linspace(values.min() - pad, values.max() + pad, 41))
        scales.append(1e-6 if gridded else np.ptp(values))
    across, up = np.meshgrid(*((edge[1:] + edge[:-1]) / 2.0 for edge in edges))
    distance = ((across[..., None] - x) / scales[0]) ** 2 + ((up[..., None] - y) / scales[1]) ** 2
    near = min(max(5, len(x) // 20), len(x))
    nearest = np.argpartition(distance, near - 1, axis=-1)[..., :near]
    return edges[0], edges[1], failed[nearest].mean(axis=-1)
