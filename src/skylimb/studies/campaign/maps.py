"""The report's maps over two parameters: where each controller fails, and who wins."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from skylimb.analysis.figures import style
from skylimb.studies.campaign.panels import add_legend, panels
from skylimb.studies.campaign.statistics import Scores

CLEAR_WIN = 0.6
"""Share of a cell's draws that a controller must win for the cell to have its colour."""

_NOBODY = "#C8CCD2"
"""Colour of a cell without a clear winner."""

_CELLS = 7
"""Cells along a parameter, at most. A grid of no more values has a cell for each."""

_IN_CELL = 8
"""Draws that a cell has on average, at least, where the parameters are no grid."""


@style.styled
def failure_map(scores: Scores, first: str, second: str) -> Figure:
    """Successes and failures over two parameters, a panel a controller."""
    figure, axes = panels(scores.controllers, 1.9, (scores.called(first), scores.called(second)))
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
    figure, ax = style.sheet(3.0, width=0.62 * style.WIDTH)
    costs, count = scores.cost(score), len(scores.controllers)
    best = np.where(np.isfinite(costs.min(axis=1)), np.argmin(costs, axis=1), count)  # the last: nobody
    x, y = (scores.parameters[name].astype(float) for name in (first, second))
    edges = _edges(x, _cells(len(x))), _edges(y, _cells(len(y)))
    wins = np.array([np.histogram2d(x[best == k], y[best == k], edges)[0] for k in range(count + 1)])
    draws = wins.sum(axis=0)
    winner = np.where(wins[:count].max(axis=0) >= CLEAR_WIN * draws, wins[:count].argmax(axis=0), count)
    shown = np.ma.masked_where(draws == 0, winner)
    colours = ListedColormap([*style.colours_of(scores.controllers), _NOBODY])
    ax.pcolormesh(
        *edges, shown.T, cmap=colours, vmin=0, vmax=count, alpha=0.8, edgecolor="white", linewidth=0.8
    )
    middles = [(edge[1:] + edge[:-1]) / 2.0 for edge in edges]
    for (i, j), number in np.ndenumerate(draws):
        if number:
            place = float(middles[0][i]), float(middles[1][j])
            ax.text(*place, f"{number:.0f}", ha="center", va="center", fontsize=6, color="white")
    ax.set(xlabel=scores.called(first), ylabel=scores.called(second))
    add_legend(figure, scores)
    return figure


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
