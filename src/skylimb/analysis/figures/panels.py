"""Signals over time, a column of panels for each run: the one layout of every such figure."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from skylimb.analysis.figures import style
from skylimb.analysis.figures.marks import event_signs, mark_events
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.signals import in_contact, spans

BRIDGE = 0.25
"""Seconds: shading is not interrupted by a shorter pause."""

_TICKS = 5
"""Most intervals of the axis of time; of a flight longer than that, in s, they begin at whole seconds."""

Shades = Iterable[tuple[float, float, str]]
"""Stretches of time: begin and end, s, and the colour in which each is shaded."""


@dataclass(frozen=True)
class Curve:
    """A curve of a panel, or a band.

    Attributes:
        values: at every sample of the log, (time,), or both edges of a band, (time, 2).
        look: what matplotlib takes: colour, width, style.
    """

    values: np.ndarray
    look: dict[str, Any]


@dataclass(frozen=True)
class Panel:
    """A panel that every run has.

    Attributes:
        label: of its vertical axis, with the unit.
        curves: of each run, by the run's name; those that come first lie below.
    """

    label: str
    curves: Mapping[str, Sequence[Curve]]


def contact_shade(log: xr.Dataset) -> Shades:
    """The stretches in which the tip touched."""
    return [(*span, style.CONTACT) for span in spans(log.time.values, in_contact(log), BRIDGE)]


def panels_figure(
    runs: Mapping[str, Run],
    panels: Sequence[Panel],
    signs: Sequence[Artist | tuple[Line2D, ...]] = (),
    shades: Callable[[xr.Dataset], Shades] = contact_shade,
) -> Figure:
    """Panels below each other for each run; a panel has the same scale for all runs.

    Args:
        runs: by name.
        panels: from the top down.
        signs: for the legend; those of events are added.
        shades: what is shaded behind the curves of a flight.
    """
    blocks, columns = style.panels(len(runs))
    wide, high = style.WIDTH * max(columns, 3) / 4, (0.55 + 1.65 * len(panels)) * blocks + 0.1
    figure, grid = style.sheet(high, len(panels) * blocks, columns, width=wide, squeeze=False, sharex=True)
    # By run, from the top down.
    grid = grid.reshape(blocks, len(panels), columns).transpose(0, 2, 1).reshape(-1, len(panels))
    for ax in grid[len(runs) :].flat:
        ax.set_axis_off()
    end = max((float(run.log.time[-1]) for run in runs.values()), default=1.0)
    limits = [
        style.limits([curve.values for own in panel.curves.values() for curve in own]) for panel in panels
    ]
    for place, (column, (name, run)) in enumerate(zip(grid, runs.items(), strict=False)):
        lowest = place + columns >= len(runs)
        style.title(column[0], name, run)
        for ax, panel, span in zip(column, panels, limits, strict=True):
            mark_events(ax, run.log, numbered=ax is column[0])
            for begin, stop, colour in shades(run.log):
                ax.axvspan(begin, stop, color=colour, linewidth=0, zorder=0)
            draw(ax, run.log, panel.curves[name])
            ax.set(xlim=(0.0, end), ylim=span)
            ax.tick_params(labelbottom=lowest and ax is column[-1], labelleft=place % columns == 0)
            if place % columns == 0:
                ax.set_ylabel(panel.label)
        column[-1].xaxis.set_major_locator(MaxNLocator(_TICKS, integer=end > _TICKS))
        if lowest:
            column[-1].set_xlabel("time (s)")
    if every := [*signs, *event_signs(runs)]:
        style.legend_below(figure, every)
    return figure


def draw(ax: Axes, log: xr.Dataset, curves: Sequence[Curve], legend: bool = True) -> None:
    """Draw the curves of one panel, thinned, with a legend of those that have a label."""
    keep = style.thin(log.sizes["time"])
    time = log.time.values[keep]
    for curve in curves:
        values = curve.values[keep]
        if values.ndim == 2:
            ax.fill_between(time, *values.T, **curve.look)
        else:
            ax.plot(time, values, **curve.look)
    if (labels := ax.get_legend_handles_labels()[1]) and legend:
        ax.legend(loc="upper right", ncols=len(labels))
