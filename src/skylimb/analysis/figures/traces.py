"""What the pen drew on the board, one panel a run."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from skylimb.analysis.figures import style
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.board import board_of, nominal_path, on_board, strokes
from skylimb.analysis.scores.pen_line import as_seen, in_plane, reference_line
from skylimb.analysis.scores.signals import post_axis

_FLAT = 0.8
"""Inches: a panel that is no taller has room for two numbers beside it."""

_SLIMMEST = 0.25
"""What is drawn of a straight line's breadth, as a share of its length: room for the numbers beside it."""


@style.styled
def pen_traces(runs: Mapping[str, Run]) -> Figure:
    """The pen's traces in the board's own coordinates, seen from the robot, with the nominal path dashed.

    A way around a post is unrolled, as it is scored: seen from before the post, its back lies on its front.

    Args:
        runs: by name, any number of them.

    Returns:
        A figure with one panel a run, all on the same scale. A run whose log describes no surface has the
        sliding axes instead.
    """
    drawn = {name: _lines(run.log) for name, run in runs.items()}
    everything = [line for nominal, traces in drawn.values() for line in (nominal, *traces)]
    across = style.limits([line[:, 0] for line in everything])
    upward = style.limits([line[:, 1] for line in everything])
    wide, tall = (_SLIMMEST * (high - low) for low, high in (across, upward))
    across, upward = style.as_wide(across, tall), style.as_wide(upward, wide)
    rows, columns = style.panels(len(runs))
    wide = style.WIDTH * max(columns, 2) / 4
    tall = min((wide / columns - 0.4) * (upward[1] - upward[0]) / (across[1] - across[0]), 4.0)
    figure = Figure(figsize=(wide, rows * (tall + 0.33) + 0.68), layout="compressed")
    axes = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    colour = style.colours(runs)
    for ax, (name, run) in zip(axes.flat, runs.items(), strict=False):
        nominal, traces = drawn[name]
        ax.plot(*nominal.T, **style.AS_REFERENCE)
        for trace in traces:
            ax.plot(*trace.T, color=colour[name], linewidth=1.6)
        if traces:
            ax.plot(*traces[0][0], "o", color=colour[name], markersize=4.5, markeredgecolor="white")
        style.title(ax, name, run)
        ax.set(aspect="equal", xlim=across, ylim=upward)
        ax.xaxis.set_major_locator(MaxNLocator(4))
        ax.yaxis.set_major_locator(MaxNLocator(5 if tall > _FLAT else 2))
    around = all(post_axis(run.log) is not None for run in runs.values())
    names = ("around the post (m)", "up (m)") if around else ("across the board (m)", "up the board (m)")
    style.label_outer(axes, len(runs), *names)
    style.legend_below(
        figure,
        [
            Line2D([], [], label="nominal path", **style.AS_REFERENCE),
            style.in_all_colours(runs, "drawn by the pen", linewidth=1.6),
            style.in_all_colours(
                runs, "first touch", marker="o", markersize=4.5, markeredgecolor="white", linestyle=""
            ),
        ],
    )
    return figure


def _lines(log: xr.Dataset) -> tuple[np.ndarray, list[np.ndarray]]:
    """The nominal path and the drawn strokes, thinned, in coordinates on the board or around the post."""
    touched = strokes(log)
    thin = style.thin(sum(stroke.stop - stroke.start for stroke in touched))
    if post_axis(log) is not None:
        pen = as_seen(log, in_plane(log, log.tip_position.values))
        nominal = as_seen(log, np.concatenate([np.zeros((0, 2)), *reference_line(log)]))
        return nominal, [pen[stroke][thin] for stroke in touched]
    board = board_of(log)
    path = nominal_path(log, board)
    nominal = on_board(log, path[style.thin(len(path), 200)], board)
    return nominal, [on_board(log, log.tip_position.values[stroke][thin], board) for stroke in touched]
