"""A drawing: the reference line, the line drawn, and how far they are apart."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from skylimb.analysis.figures import style
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.pen_line import (
    as_seen,
    drawn_samples,
    marks,
    pen_deviation,
    pen_line,
    reference_line,
)
from skylimb.analysis.scores.signals import around, samples_within

SMOOTHING = 0.1
"""Seconds over which the normal force is averaged before it is drawn."""

_BRIDGE = 0.05
"""A loss of touch up to this long, s, does not break the line."""
_MOST = 4000
"""Pieces of a drawn line."""
_TALLEST, _LEAST = 4.5, 0.8
"""Inches of a panel: its height at most, and its height and width at least."""
_BAR = 0.2
"""Inches: the width of the colour bar at most."""
_TICK = 0.4
"""Inches from one number below a panel to the next, at least."""


@style.styled
def drawn_line(runs: Mapping[str, Run]) -> Figure:
    """The reference line and the drawn one as seen from the robot, coloured by force; below, their distance.

    Args:
        runs: by name, any number of them.

    Returns:
        A figure with one panel a run, all on the same scale, and one for the distances of all.
    """
    wanted = {
        name: [as_seen(run.log, line) for line in reference_line(run.log)] for name, run in runs.items()
    }
    drawn = {name: _drawn(run.log) for name, run in runs.items()}
    touched = {name: as_seen(run.log, marks(run.log)[1]) for name, run in runs.items()}
    everything = [part for lines in wanted.values() for part in lines] + list(touched.values())
    across, upward = (style.limits([points[..., axis] for points in everything]) for axis in (0, 1))
    rows, columns = style.panels(len(runs), 2)
    panel = (style.WIDTH - 1.0) / columns
    # A drawing that is a line has a scale in both directions as well.
    upward = style.as_wide(upward, _LEAST / panel * (across[1] - across[0]))
    across = style.as_wide(across, _LEAST / _TALLEST * (upward[1] - upward[0]))
    tall = min(panel * (upward[1] - upward[0]) / (across[1] - across[0]), _TALLEST)
    wide = tall * (across[1] - across[0]) / (upward[1] - upward[0])
    figure = Figure(figsize=(style.WIDTH, rows * (tall + 0.5) + 2.5), layout="constrained")
    grid = figure.add_gridspec(rows + 1, columns, height_ratios=[tall] * rows + [1.3])
    axes = np.empty((rows, columns), dtype=object)
    for row, column in np.ndindex(rows, columns):
        axes[row, column] = figure.add_subplot(grid[row, column], sharex=axes[0, 0], sharey=axes[0, 0])
    forces = np.concatenate([force for _, force in drawn.values()])
    strongest = float(np.percentile(forces, 98)) if len(forces) else 1.0
    scale = Normalize(0.0, max(strongest, 1e-3))
    lines: Any = None
    for ax, (name, run) in zip(axes.flat, runs.items(), strict=False):
        for line in wanted[name]:
            ax.plot(*line.T, color=style.DARK, linewidth=0.5, zorder=1.5)
        ax.plot(*touched[name].T, ".", color=style.TRUTH, markersize=1.5, zorder=1)
        pieces, force = drawn[name]
        lines = LineCollection(list(pieces), array=force, norm=scale, cmap="viridis_r", linewidth=1.8)
        ax.add_collection(lines)
        style.title(ax, name, run)
        ax.set(aspect="equal", xlim=across, ylim=upward)
        ax.xaxis.set_major_locator(MaxNLocator(max(2, min(7, round(wide / _TICK)))))
        ax.yaxis.set_major_locator(MaxNLocator(5))
    style.label_outer(axes, len(runs), "to the right, seen from the robot (m)", "up (m)")
    slim = max(15.0, rows * tall / _BAR)
    extend = "max" if len(forces) and forces.max() > scale.vmax else "neither"
    look = {"pad": 0.01, "aspect": slim, "extend": extend}
    figure.colorbar(lines, ax=axes.ravel().tolist(), label="normal force (N)", **look)
    _distances(figure.add_subplot(grid[rows, :]), runs)
    style.legend_below(
        figure,
        [
            Line2D([], [], color=style.DARK, linewidth=0.5, label="reference"),
            Line2D([], [], color="#3b7d8c", linewidth=1.8, label="drawn, coloured by force"),
            Line2D([], [], color=style.TRUTH, marker=".", linewidth=0, label="touching down, leaving"),
        ],
    )
    return figure


def _distances(ax: Axes, runs: Mapping[str, Run]) -> None:
    """Distance of the drawn line from the reference line over the length drawn so far."""
    colour = style.colours(runs)
    for name, run in runs.items():
        samples, points = drawn_samples(run.log)
        away = pen_deviation(run.log)
        if not len(away):
            continue
        step = np.linalg.norm(np.diff(points, axis=0), axis=1) * _joined(run.log, samples)
        way = np.concatenate([[0.0], np.cumsum(step)])
        text = style.marked(name, run) if run.failed else f"{style.label(name)}: {_numbers(run)}"
        thin = style.thin(len(way), 3000)
        ax.plot(way[thin], 1e3 * away[thin], color=colour[name], linewidth=0.8, label=text)
    ax.set(xlabel="length drawn (m)", ylabel="off its reference (mm)", ylim=(0.0, None))
    ax.margins(x=0.01)
    if ax.get_legend_handles_labels()[0]:
        ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2)


def _numbers(run: Run) -> str:
    """How far a run's line is off; a flight that failed has no such numbers."""
    off = pen_line(run)
    text = f"rms {1e3 * off['rms']:.1f} mm, largest {1e3 * off['max']:.1f} mm"
    for title in ("place", "shape"):
        if (apart := run.metrics.get(f"line_{title}")) is not None:
            text += f", {title} {1e3 * apart:.1f} mm"
    return text


def _drawn(log: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Pieces of the drawn line as seen from the robot, (n, 2, 2), m, and the force at each, (n,), N."""
    samples, points = drawn_samples(log)
    force = log.contact_force_normal.values[samples] if "contact_force_normal" in log else 0.0 * samples
    if len(force):  # the eye sees no single sample
        force = around(force, samples_within(log.time.values, SMOOTHING)).mean(axis=-1)
    thin = style.thin(len(samples), _MOST)
    points, force, joined = as_seen(log, points[thin]), force[thin], _joined(log, samples[thin])
    pieces = np.stack([points[:-1], points[1:]], axis=1)
    return pieces[joined], (0.5 * (force[1:] + force[:-1]))[joined]


def _joined(log: xr.Dataset, samples: np.ndarray) -> np.ndarray:
    """Whether the pen went from each sample to the next without leaving the surface for long."""
    time = log.time.values[samples]
    spacing = np.median(np.diff(time)) if len(time) > 1 else 0.0
    return np.diff(time) <= _BRIDGE + spacing
