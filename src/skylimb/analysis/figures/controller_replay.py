"""A replay beside what was recorded, over time."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from itertools import zip_longest
from typing import Any

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from skylimb.analysis.figures import style
from skylimb.analysis.figures.marks import event_signs, mark_events
from skylimb.analysis.figures.panels import draw
from skylimb.analysis.figures.plotting import entries
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.signals import at_ticks

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

_RECORDED: dict[str, Any] = {"color": style.TRUTH, "linewidth": 2.2}
_REPLAYED: dict[str, Any] = {"color": style.CURVES[0], "linewidth": 0.7}


def replayed_figures(recorded: Run, replayed: Run) -> dict[str, Figure]:
    """The figures of a replay by name; without those for which neither run has a signal."""
    known = {
        figure: [name for name in signals if name in replayed.log or name in recorded.log]
        for figure, signals in FIGURES.items()
    }
    return {figure: _beside(recorded, replayed, signals) for figure, signals in known.items() if signals}


@style.styled
def _beside(recorded: Run, replayed: Run, signals: Sequence[str]) -> Figure:
    """A row a signal and a panel an entry, on the clock of the record: the replay in blue on top of it."""
    was = at_ticks(recorded.log, replayed.log)
    rows = [
        list(zip_longest(entries(was, name, _RECORDED), entries(replayed.log, name, _REPLAYED)))
        for name in signals
    ]
    columns = max(map(len, rows))
    figure, axes = style.sheet(1.15 * len(signals) + 0.5, len(signals), columns, sharex=True, squeeze=False)
    for row, name, pairs in zip(axes, signals, rows, strict=True):
        for ax, pair in zip(row, pairs, strict=False):
            curves = list(filter(None, pair))
            draw(ax, was, curves, legend=False)
            ax.set_title(curves[0].look["label"] or "")
            mark_events(ax, was, numbered=ax is axes[0, 0])
        for ax in row[len(pairs) :]:
            ax.set_axis_off()
        unit = (replayed.log if name in replayed.log else was)[name].attrs.get("units", "")
        words = textwrap.fill(name.removesuffix("_estimate").removesuffix("_command").replace("_", " "), 16)
        row[0].set_ylabel(f"{words}\n({unit})" if unit else words)
    for ax in axes[-1]:
        ax.set_xlabel("time (s)")
    signs = (
        Line2D([], [], label=f"recorded: {recorded.controller}", **_RECORDED),
        Line2D([], [], label=f"replayed: {replayed.controller}", **_REPLAYED),
    )
    style.legend_below(figure, [*signs, *event_signs({recorded.name: recorded})])
    return figure
