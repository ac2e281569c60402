"""A strip of poses seen from above, which shows the robot deform as the board comes nearer or recedes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from skylimb.analysis.figures import style
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.axis_names import axis_names
from skylimb.analysis.scores.board import board_of
from skylimb.analysis.scores.signals import contact_axis, in_phase

FRACTIONS = (0.0, 0.25, 0.5, 0.75, 1.0)
"""The parts of the sliding period at which a pose is drawn."""

SCALE = 0.5
"""The length of the scale bar, m."""

_OVER_POSES = 12.0
"""Points between the poses and their titles: the scale bar stands there."""

_AROUND = 0.9
"""Inches of the figure's height that are not poses: titles, scale bar and legend."""

LEVEL = 0.7
"""A surface whose normal has a vertical part above this is more floor than wall."""

GHOST = "#C9CDD2"
BOARD = "#8A6D3B"


@style.styled
def poses(runs: Mapping[str, Run]) -> Figure:
    """The robot from above at five instants of the sliding period, a row a run.

    Args:
        runs: by name, any number of them. The instants are parts of the mission's sliding period; a flight
            that ended before it was over has fewer poses. Where all did, nobody knows how long it was to be:
            they are parts of what the longest flew of it.

    Returns:
        A figure; in every panel the shape before the contact stands behind in grey, its centre of gravity at
        the mission's reference. What is seen to differ is how far the body was moved and how the shape
        changed. The line at the right is the board at the pen's height.
    """
    period = max((_progress(run.log)[-1] for run in runs.values()), default=0.0)
    instants = {name: _instants(run.log, period) for name, run in runs.items()}
    points = [
        chain
        for name, run in runs.items()
        for index in instants[name]
        for chain in (run.log.skeleton.values[index], _ghost(run.log, index))
    ]
    boards = (_board_line(run.log, index) for name, run in runs.items() for index in instants[name])
    lines = [line for line in boards if line is not None]
    across = style.limits([part[:, 0] for part in (*points, *lines)], 0.03)
    low, high = style.limits([part[:, 1] for part in points], 0.05)
    upward = low - 0.42, high  # displacement and reach are written below the robot
    columns = len(FRACTIONS)
    tall = (style.WIDTH - 0.3) / columns * (upward[1] - upward[0]) / (across[1] - across[0])
    figure, axes = style.sheet(len(runs) * tall + _AROUND, len(runs), columns, squeeze=False)
    colour = style.colours(runs)
    for row, (name, run) in zip(axes, runs.items(), strict=True):
        for ax in row:
            ax.set(aspect="equal", xlim=across, ylim=upward, xticks=[], yticks=[])
            ax.spines[:].set_visible(False)
        shade = style.FAILURE if run.failed else colour[name]
        row[0].set_ylabel(style.marked(name, run), color=shade, weight="bold")
        for ax, index in zip(row, instants[name], strict=False):
            _pose(ax, run.log, index, colour[name])
    what = "the path" if any(_went_through(run.log) for run in runs.values()) else "what was flown"
    for ax, fraction in zip(axes[0], FRACTIONS, strict=True):
        ax.set_title(f"{fraction:.0%} of {what}" if fraction else "start of the path", pad=_OVER_POSES)
    _scale_bar(axes[0, 0], across[0], high)
    style.legend_below(
        figure,
        [
            style.in_all_colours(runs, "links", linewidth=2.6),
            Line2D([], [], color=GHOST, linewidth=2.6, label="before contact, at the reference"),
            Line2D([], [], color=style.DARK, marker="P", markersize=5, linestyle="", label="CoG"),
            Line2D(
                [],
                [],
                color="white",
                marker="P",
                markersize=5,
                markeredgecolor=style.DARK,
                linestyle="",
                label="its reference",
            ),
            Line2D([], [], color=BOARD, linewidth=2.0, label="board"),
        ],
    )
    return figure


def poses_seen(runs: Mapping[str, Run]) -> bool:
    """Whether a flight lived to slide, so that there is a pose to draw."""
    return any(_instants(run.log, 0.0) for run in runs.values())


def _went_through(log: xr.Dataset) -> bool:
    """Whether a flight came to the end of its sliding period."""
    sliding = in_phase(log, "slide")
    return bool(sliding.any() and not sliding[-1])


def _progress(log: xr.Dataset) -> np.ndarray:
    """How much of the sliding period was over at each of its samples, s on the mission's clock; 0 for none.

    A controller may hold that clock back: then the same part of the path comes later in its flight.
    """
    clock = log.mission_time if "mission_time" in log else log.time
    times = clock.values[in_phase(log, "slide")]
    return times - times[0] if times.size else np.zeros(1)


def _instants(log: xr.Dataset, period: float) -> list[int]:
    """Samples at the wanted parts of the sliding period, as many as the flight lived to see."""
    sliding = np.flatnonzero(in_phase(log, "slide"))
    if not sliding.size or "skeleton" not in log:
        return []
    passed, wanted = _progress(log), np.asarray(FRACTIONS) * period
    seen = wanted <= passed[-1] + 0.02 * period
    return [int(sliding[np.argmin(np.abs(passed - instant))]) for instant in wanted[seen]]


def _pose(ax: Axes, log: xr.Dataset, index: int, colour: str) -> None:
    chain, ghost = log.skeleton.values[index], _ghost(log, index)
    cog, reference = log.cog_position.values[index], log.cog_position_reference.values[index]
    ax.plot(ghost[:, 0], ghost[:, 1], color=GHOST, linewidth=2.6)
    line = _board_line(log, index)
    if line is not None:
        ax.plot(line[:, 0], line[:, 1], color=BOARD, linewidth=2.0)
    ax.plot(chain[:, 0], chain[:, 1], color=colour, linewidth=2.6)
    ax.plot(chain[:-1, 0], chain[:-1, 1], "o", color="white", markeredgecolor=colour, markersize=3.6)
    ax.plot(*reference[:2], "P", color="white", markersize=5, markeredgecolor=style.DARK, markeredgewidth=0.5)
    ax.plot(*cog[:2], "P", color=style.DARK, markersize=5, markeredgecolor="white", markeredgewidth=0.5)
    along = contact_axis(log).along(cog - reference)
    lines = [f"moved {along:+.2f} m in {axis_names(log).n}".replace("-", "\N{MINUS SIGN}")]
    if "reach" in log:
        lines.append(f"reach {float(log.reach[index]):.2f} m")
    text = "\n".join(lines)
    ax.text(0.5, 0.0, text, transform=ax.transAxes, fontsize=6.5, ha="center", va="bottom")


def _ghost(log: xr.Dataset, index: int) -> np.ndarray:
    """The shape before the contact with its centre of gravity at the reference: W, m, shape (nodes, 3)."""
    before = log.skeleton.values[0] - log.cog_position.values[0]
    return before + log.cog_position_reference.values[index]


def _scale_bar(ax: Axes, left: float, top: float) -> None:
    """Between the poses and their titles, where no robot is."""
    place = left + 0.45 + np.array([0.0, SCALE])
    ax.plot(place, [top + 0.03] * 2, color=style.DARK, linewidth=1.0, clip_on=False)
    ax.text(place[1] + 0.05, top + 0.03, f"{SCALE} m", fontsize=6.5, ha="left", va="center")


def _board_line(log: xr.Dataset, index: int) -> np.ndarray | None:
    """The surface's cut at the height of the tip, or None for one that is seen from above as an area."""
    board = board_of(log)
    if board is None or abs(board.normal[2]) > LEVEL:
        return None
    return board.cut(float(log.skeleton.values[index, -1, 2]))
