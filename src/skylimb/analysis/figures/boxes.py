"""Distributions over the sliding period, one box a run, with the paper's medians where it prints them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from skylimb.analysis.figures import style
from skylimb.analysis.paper.numbers import published_beside
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.axis_names import common_names
from skylimb.analysis.scores.signals import contact_axis, in_phase, off_mission, sliding_axes

WHISKERS = (5.0, 95.0)
"""Percentiles at which the whiskers end.

A flight's samples depend on each other: outliers one by one mean little.
"""

_BOX = 0.4
"""Width of a box, of the distance between two."""

_BESIDE, _NUMBERED = 4, 10
"""Runs for which two panels stand beside each other, and for which a median has room for its number."""

_PER_LETTER = 0.045
"""Height of a letter of a name that leans, inches."""

Quantity = Callable[[xr.Dataset], np.ndarray]


@style.styled
def sliding_errors(runs: Mapping[str, Run]) -> Figure:
    """Box plots of the CoG's absolute errors to the mission's reference along the two sliding axes.

    Args:
        runs: by name, any number of them; a failed flight has no box.

    Returns:
        A figure with a panel for each sliding axis.
    """
    axes = common_names(run.log for run in runs.values())
    return _figure(
        runs,
        [
            (
                axes.label("|{u} error| of the CoG to the mission (m)"),
                "error_u_median",
                lambda log: np.abs(off_mission(log, sliding_axes(log)[0])),
            ),
            (
                axes.label("|{v} error| of the CoG to the mission (m)"),
                "error_v_median",
                lambda log: np.abs(off_mission(log, sliding_axes(log)[1])),
            ),
        ],
    )


@style.styled
def contact_distributions(runs: Mapping[str, Run]) -> Figure:
    """Box plots of the CoG's absolute displacement and of the estimated force along the contact axis.

    Args:
        runs: by name, any number of them; a failed flight has no box.

    Returns:
        A figure with a panel for the displacement and one for the force.
    """
    axes = common_names(run.log for run in runs.values())
    return _figure(
        runs,
        [
            (
                axes.label("|{n} displacement| from the mission (m)"),
                "displacement_median",
                lambda log: np.abs(off_mission(log, contact_axis(log))),
            ),
            (axes.label("estimated force in {signed} (N)"), "estimated_force_median", _force),
        ],
    )


def _figure(runs: Mapping[str, Run], quantities: list[tuple[str, str, Quantity]]) -> Figure:
    wide = style.WIDTH * min(1.0, max(0.62, 0.25 * len(runs)))
    rows, columns = (1, len(quantities)) if len(runs) <= _BESIDE else (len(quantities), 1)
    height = 2.7 + (_PER_LETTER * max(len(style.label(name)) for name in runs) if _crowded(runs) else 0.0)
    figure, axes = style.sheet(height * rows, rows, columns, width=wide, squeeze=False)
    printed = False
    for ax, (text, metric, quantity) in zip(axes.flat, quantities, strict=True):
        printed |= _panel(ax, runs, metric, quantity)
        ax.set_ylabel(text)
    handles: list[Any] = [
        Patch(
            facecolor="#DDDDDD",
            edgecolor=style.DARK,
            linewidth=0.8,
            label=f"quartiles and median; whiskers {WHISKERS[0]:g} to {WHISKERS[1]:g} %",
        )
    ]
    if printed:
        look = {"color": style.DARK, "markerfacecolor": "white", "linestyle": "", "markersize": 4.5}
        handles.append(Line2D([], [], marker="D", label="median in the paper", **look))
    style.legend_below(figure, handles)
    return figure


def _crowded(runs: Mapping[str, Run]) -> bool:
    """Whether names have to lean, so that none stands on another."""
    longest = max((len(style.label(name)) for name in runs), default=0)
    return longest * len(runs) > (50 if len(runs) <= _BESIDE else 100)


def _panel(ax: Axes, runs: Mapping[str, Run], metric: str, quantity: Quantity) -> bool:
    """One panel; whether it shows a number of the paper's."""
    colour = style.colours(runs)
    printed = False
    for place, (name, run) in enumerate(runs.items()):
        values = (
            np.zeros(0)
            if run.failed
            else quantity(run.log.isel(time=np.flatnonzero(in_phase(run.log, "slide"))))
        )
        if values.size:
            _box(ax, place, values, colour[name], numbered=len(runs) <= _NUMBERED)
        else:
            text = run.mark or "no data"
            shade = style.FAILURE if run.failed else style.TRUTH
            middle = {"transform": ax.get_xaxis_transform(), "ha": "center", "va": "center"}
            ax.text(place, 0.5, text, rotation=90, color=shade, **middle)
        number = published_beside(run, metric)
        if number is not None:
            ax.plot(
                place - 0.29,
                number,
                "D",
                color=style.DARK,
                markerfacecolor="white",
                markersize=4.5,
                zorder=5,
            )
            printed = True
    names = [style.label(name) for name in runs]
    crowded = _crowded(runs)
    ax.set_xticks(range(len(runs)), names, rotation=30 if crowded else 0, ha="right" if crowded else "center")
    ax.set_xlim(-0.65, len(runs) - 0.2)
    ax.tick_params(axis="x", length=0)
    ax.yaxis.set_major_locator(MaxNLocator(6))  # the same whatever the height that the layout finds
    low, high = ax.get_ylim()
    ax.set_ylim(0.0 if low + 0.06 * (high - low) >= 0.0 else low, high)
    ax.grid(axis="y", color="#E6E6E6", linewidth=0.5)
    return printed


def _box(ax: Axes, place: int, values: np.ndarray, colour: str, numbered: bool) -> None:
    low, first, median, third, high = np.percentile(values, [WHISKERS[0], 25, 50, 75, WHISKERS[1]])
    edge = {"color": style.DARK, "linewidth": 0.8}
    ax.bxp(
        [{"med": median, "q1": first, "q3": third, "whislo": low, "whishi": high, "fliers": []}],
        positions=[place],
        widths=_BOX,
        patch_artist=True,
        showfliers=False,
        manage_ticks=False,
        boxprops={"facecolor": colour, "edgecolor": style.DARK, "linewidth": 0.8, "alpha": 0.75},
        medianprops={"color": style.DARK, "linewidth": 1.6},
        whiskerprops=edge,
        capprops=edge,
    )
    if not numbered:
        return
    words = f"{median:.3f}".replace("-", "\N{MINUS SIGN}")
    beside = {"textcoords": "offset points", "xytext": (2, 0), "va": "center", "fontsize": 6.5}
    ax.annotate(words, (place + 0.5 * _BOX, median), color=style.DARK, **beside)


def _force(log: xr.Dataset) -> np.ndarray:
    if "external_force_estimate" not in log:
        return np.zeros(0)
    return contact_axis(log).along(log.external_force_estimate.values)
