"""How far a task with a tool came over time, one panel a run."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from skylimb.analysis.figures import style
from skylimb.analysis.figures.panels import Curve, Panel, panels_figure
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.task import TOOLS, Tool

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
    tool, colour = common_tool(runs), style.colours(runs)
    scale, unit = _SHOWN[tool.unit] if tool else (1.0, "")
    title = tool.title.lower() if tool else "no tool"

    def curves(name: str) -> list[Curve]:
        if tool is None:
            return []
        log = runs[name].log
        wanted = np.full(log.sizes["time"], scale * tool.commanded(log))
        way = Curve(scale * log[tool.signal].values, {"color": colour[name]})
        return [Curve(wanted, style.AS_REFERENCE), way]

    panel = Panel(f"{title} ({unit})" if tool else title, {name: curves(name) for name in runs})
    signs = [
        style.in_all_colours(runs, title),
        Line2D([], [], label="commanded", **style.AS_REFERENCE),
        style.swatch(style.CONTACT, "in contact"),
    ]
    return panels_figure(runs, [panel], signs)
