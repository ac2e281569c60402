"""How far a task with a tool came over time, one panel a run."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from skylimb.analysis.figures import style
from skylimb.analysis.figures.marks import event_signs, mark_events
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.signals import in_contact, spans
from skylimb.analysis.scores.task import TOOLS, Tool

BRIDGE = 0.25
"""Seconds: shading is not interrupted by a shorter pause."""

_SHOWN = {"rad": (np.degrees(1.0), "\N{DEGREE SIGN}"), "m": (1e3, "mm")}
"""Scale and unit in which a tool's way is drawn."""


def common_tool(runs: Mapping[str, Run]) -> Tool | None:
    """The tool that all these flights had, if there is one."""
    shared = (tool for tool in TOOLS if runs and all(tool.signal in run.log for run in runs.values()))
    return next(shared, None)


@style.styled
def task_progress(runs: Mapping[str, Run]) -> Figure:
    """What was done with the tool over time, what was commanded dashed, and the touch shaded.

    Args:
        runs: by name, any number of them, with a tool in common.

    Returns:
        A figure with one panel a run, all on the same scale, in degrees or millimetres; empty panels where
        the runs have no tool in common.
    """
    tool = common_tool(runs)
    scale, unit = _SHOWN[tool.unit] if tool else (1.0, "")
    ways = {name: scale * run.log[tool.signal].values for name, run in runs.items()} if tool else {}
    wanted = {name: scale * tool.commanded(run.log) for name, run in runs.items()} if tool else {}
    span = style.limits([*ways.values(), np.array(list(wanted.values()))])
    rows, columns = style.panels(len(runs))
    figure = Figure(figsize=(style.WIDTH * max(columns, 3) / 4, 2.2 * rows + 0.4), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    colour = style.colours(runs)
    for ax, (name, run) in zip(axes.flat, runs.items(), strict=False):
        time = run.log.time.values
        style.shade(ax, spans(time, in_contact(run.log), BRIDGE), style.CONTACT)
        mark_events(ax, run.log, numbered=True)
        if name in ways:
            ax.axhline(wanted[name], **style.AS_REFERENCE)
            keep = style.thin(len(time))
            ax.plot(time[keep], ways[name][keep], color=colour[name])
        style.title(ax, name, run)
        ax.set(ylim=span)
        ax.xaxis.set_major_locator(MaxNLocator(5, integer=True))
    title = tool.title.lower() if tool else "no tool"
    style.label_outer(axes, len(runs), "time (s)", f"{title} ({unit})" if tool else title)
    style.legend_below(
        figure,
        [
            style.in_all_colours(runs, title),
            Line2D([], [], label="commanded", **style.AS_REFERENCE),
            style.swatch(style.CONTACT, "in contact"),
            *event_signs(runs),
        ],
    )
    return figure
