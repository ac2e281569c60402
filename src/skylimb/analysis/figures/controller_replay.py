"""A replay beside what was recorded, over time."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from skylimb.analysis.figures import style
from skylimb.analysis.figures.marks import event_signs, mark_events
from skylimb.analysis.recording import Run

FIGURES = {
    "estimates": (
        "external_force_estimate",
        "external_torque_estimate",
        "cog_position_estimate",
        "cog_velocity_estimate",
        "external_force_filtered",
        "normal_force_estimate",
    ),
    "commands": (
        "thrusts_command",
        "joint_angles_command",
        "vectoring_angles_command",
        "force_command",
        "torque_command",
        "attitude_target",
    ),
}
"""Figures, each with the signals that have a row in it."""

_LETTERS = 16
"""In a line beside a row of panels."""

_RECORDED, _REPLAYED = style.TRUTH, style.CURVES[0]


def replayed_figures(recorded: Run, replayed: Run) -> dict[str, Figure]:
    """The figures of a replay by name; without those for which neither run has a signal."""
    known = {
        figure: [name for name in signals if name in replayed.log or name in recorded.log]
        for figure, signals in FIGURES.items()
    }
    return {figure: _beside(recorded, replayed, signals) for figure, signals in known.items() if signals}


@style.styled
def _beside(recorded: Run, replayed: Run, signals: Sequence[str]) -> Figure:
    """A row a signal and a panel an entry: recorded thick and grey, replayed thin and blue on top of it."""
    pairs = [(_entries(recorded.log, name), _entries(replayed.log, name)) for name in signals]
    columns = max(len(was) or len(now) for was, now in pairs)
    figure = Figure(figsize=(style.WIDTH, 1.15 * len(signals) + 0.5), layout="constrained")
    axes = figure.subplots(len(signals), columns, sharex=True, squeeze=False)
    begin = float(recorded.log.time.values[0])
    for row, name, (was, now) in zip(axes, signals, pairs, strict=True):
        labels = list(was or now)
        for ax, label in zip(row, labels, strict=False):
            for curves, run, start, look in (
                (was, recorded, begin, {"color": _RECORDED, "linewidth": 2.2}),
                (now, replayed, 0.0, {"color": _REPLAYED, "linewidth": 0.7}),
            ):
                if label in curves:
                    step = style.thin(len(curves[label]))
                    ax.plot(run.log.time.values[step] - start, curves[label][step], **look)
            if label:
                ax.set_title(label)
            mark_events(ax, recorded.log, numbered=ax is axes[0, 0], shift=begin)
        for ax in row[len(labels) :]:
            ax.set_axis_off()
        source = replayed.log if name in replayed.log else recorded.log
        unit = source[name].attrs.get("units", "")
        words = name.removesuffix("_estimate").removesuffix("_command").replace("_", " ")
        words = textwrap.fill(words, _LETTERS)
        row[0].set_ylabel(f"{words}\n({unit})" if unit else words)
    for ax in axes[-1]:
        ax.set_xlabel("time (s)")
    signs = (
        Line2D([], [], color=_RECORDED, linewidth=2.2, label=f"recorded: {recorded.controller}"),
        Line2D([], [], color=_REPLAYED, linewidth=0.9, label=f"replayed: {replayed.controller}"),
    )
    style.legend_below(figure, [*signs, *event_signs({recorded.name: recorded})])
    return figure


def _entries(log: xr.Dataset, name: str) -> dict[str, np.ndarray]:
    """The entries of a signal by what each is called; none where the log has no such signal."""
    if name not in log:
        return {}
    variable = log[name]
    if variable.ndim == 1:
        return {"": variable.values}
    dimension = variable.dims[1]
    count = variable.shape[1]
    names = variable[dimension].values if dimension in variable.coords else range(count)
    return {str(label): variable.values[:, i] for i, label in enumerate(names)}
