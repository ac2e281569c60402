"""What a soft pen covered of the area that it was to cover, as seen from the robot."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from skylimb.analysis.figures import style
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.area import CELL, Areas, area_iou, areas
from skylimb.analysis.scores.pen_line import as_seen

_NOTHING = Areas(np.zeros((1, 1), dtype=bool), np.zeros((1, 1), dtype=bool), np.zeros(2))
"""Of a run without a soft pen."""
BOTH, MISSING, BESIDE = "#3b4a57", "#8fbbe8", "#e8963e"


@style.styled
def drawn_area(runs: Mapping[str, Run]) -> Figure:
    """The wanted and the drawn area of each run, a panel each, all on one scale."""
    rows, columns = style.panels(len(runs), 2)
    pictures = {name: _picture(run) for name, run in runs.items()}
    extents = np.array([extent for _, extent in pictures.values()])
    across, upward = ((extents[:, i].min(), extents[:, i + 1].max()) for i in (0, 2))
    tall = (style.WIDTH - 1.0) / columns * (upward[1] - upward[0]) / (across[1] - across[0])
    figure, axes = style.sheet(
        rows * (min(tall, 5.0) + 0.5) + 0.5, rows, columns, sharex=True, sharey=True, squeeze=False
    )
    for ax, (name, run) in zip(axes.flat, runs.items(), strict=False):
        picture, extent = pictures[name]
        ax.imshow(picture, extent=extent, origin="lower", interpolation="nearest")
        style.title(ax, name, run)
        if not run.failed:
            ax.set_title(f"IoU {area_iou(run):.2f}", loc="right", fontsize="small")
        ax.set(xlim=across, ylim=upward)
    style.label_outer(axes, len(runs), "to the right, seen from the robot (m)", "up (m)")
    words = {BOTH: "wanted and drawn", MISSING: "wanted, not drawn", BESIDE: "drawn, not wanted"}
    style.legend_below(figure, [style.swatch(colour, text) for colour, text in words.items()])
    return figure


def _picture(run: Run) -> tuple[np.ndarray, tuple[float, float, float, float]]:
    """Colours of the cells, (rows from below, columns, 4), and left, right, lower and upper edge, m."""
    found = areas(run.log) or _NOTHING
    colours = np.zeros((*found.wanted.shape, 4))
    for cells, colour in (
        (found.wanted & found.drawn, BOTH),
        (found.wanted & ~found.drawn, MISSING),
        (found.drawn & ~found.wanted, BESIDE),
    ):
        colours[cells] = [*(int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)), 1.0]
    edges = np.stack([found.low - 0.5 * CELL, found.low + (np.array(found.wanted.shape) - 0.5) * CELL])
    left, right = as_seen(run.log, edges)[:, 0]
    colours = colours if left < right else colours[::-1]
    return colours.transpose(1, 0, 2), (min(left, right), max(left, right), edges[0, 1], edges[1, 1])
