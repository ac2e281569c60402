"""The one look of every figure: sizes, fonts, colours, and how a figure is saved.

Colours follow the Okabe-Ito palette, which people with the common kinds of colour blindness can tell apart. A
controller has the same colour in every figure. Figures are built on matplotlib's objects alone, so that no
window, backend or global state of the caller's is touched.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from skylimb.analysis.fonts import families
from skylimb.recording import Run

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")

WIDTH = 7.16
"""Inches: the full width of a two-column journal page."""

DPI = 200
POINTS = 600
"""A line is drawn through at most about this many samples; more would not show at this size."""

CONTROLLER_COLOURS = {"pid": "#D55E00", "impedance": "#0072B2", "admittance": "#009E73", "hybrid": "#7A3E9D"}
OTHER_COLOURS = ("#56B4E9", "#CC79A7", "#8C6D00", "#000000", "#B2182B", "#4D4D4D")
REFERENCE = "#555555"
TRUTH = "#9A9A9A"
CONTACT = "#FBEFB5"
ADAPTATION = "#F8D5E2"
LOST = "#C9DDF0"
INK = "#1A1A1A"
FAILURE = "#B00020"

LABELS = {"pid": "PID", "impedance": "Impedance", "admittance": "Admittance", "hybrid": "Hybrid"}

RC: dict[Any, Any] = {
    "font.family": "sans-serif",
    "font.size": 8,
    "axes.titlesize": 8.5,
    "axes.titleweight": "bold",
    "axes.labelsize": 8,
    "axes.linewidth": 0.6,
    "axes.edgecolor": "#444444",
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": False,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.color": INK,
    "ytick.color": INK,
    "lines.linewidth": 1.2,
    "lines.solid_capstyle": "round",
    "legend.fontsize": 7.5,
    "legend.frameon": False,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "pdf.fonttype": 42,  # whole outlines, which journals ask for and editors can edit
    "pdf.compression": 6,
    "path.simplify": True,
}


def styled(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """Run a drawing function under this style, leaving the caller's settings as they were."""

    @wraps(function)
    def inner(*args: Parameters.args, **kwargs: Parameters.kwargs) -> Result:
        with matplotlib.rc_context():
            matplotlib.rcdefaults()
            matplotlib.rcParams.update(RC)
            matplotlib.rcParams["font.sans-serif"] = families()
            return function(*args, **kwargs)

    return inner


def colours(runs: Mapping[str, Run]) -> dict[str, str]:
    """A colour for each run.

    It is its controller's own, and another where two runs share a controller or it is not one of ours.
    """
    others = iter(OTHER_COLOURS * (1 + len(runs) // len(OTHER_COLOURS)))
    found: dict[str, str] = {}
    for name, run in runs.items():
        own = CONTROLLER_COLOURS.get(run.controller)
        found[name] = own if own and own not in found.values() else next(others)
    return found


def label(name: str) -> str:
    """How a run is called in print."""
    return LABELS.get(name, name)


def title(ax: Axes, name: str, run: Run) -> None:
    """Head a panel with the run's name; a failed flight says so."""
    ax.set_title(
        f"{label(name)} (failed)" if run.failed else label(name), color=FAILURE if run.failed else INK
    )


def thin(count: int, points: int = POINTS) -> slice:
    """A slice that keeps about `points` of `count` samples."""
    return slice(None, None, max(1, count // points))


def shade(ax: Axes, stretches: Sequence[tuple[float, float]], colour: str) -> None:
    """Shade stretches of time (s) behind the curves."""
    for begin, end in stretches:
        ax.axvspan(begin, end, color=colour, linewidth=0, zorder=0)


def panels(count: int, most: int = 4) -> tuple[int, int]:
    """Rows and columns for `count` panels, at most `most` beside each other."""
    columns = min(count, most)
    return -(-count // columns), columns


def swatch(colour: str, text: str) -> Patch:
    """A filled square for the legend."""
    return Patch(facecolor=colour, edgecolor="none", label=text)


def legend_below(figure: Figure, handles: Sequence[Any]) -> None:
    """One legend for the whole figure under the panels, in as few rows as its width allows."""
    widest = max(len(str(handle.get_label())) for handle in handles)
    fitting = int(figure.get_figwidth() / (0.5 + 0.058 * widest))  # inches for the sign and for a letter
    columns = max(1, min(fitting, len(handles)))
    figure.legend(handles=list(handles), loc="outside lower center", ncols=columns, handlelength=1.8)


def label_outer(axes: np.ndarray, used: int, below: str, beside: str) -> None:
    """Hide the panels that no run uses, and label the outer edge of those in use."""
    columns = axes.shape[1]
    for index, ax in enumerate(axes.flat):
        if index >= used:
            ax.set_axis_off()
            continue
        ax.tick_params(labelbottom=index + columns >= used)
        if index + columns >= used:
            ax.set_xlabel(below)
        if index % columns == 0:
            ax.set_ylabel(beside)


def limits(values: Sequence[np.ndarray], margin: float = 0.06) -> tuple[float, float]:
    """Common axis limits around all the finite values, with a margin (a fraction of their range)."""
    flat = np.concatenate([np.ravel(value) for value in values]) if len(values) else np.zeros(0)
    flat = flat[np.isfinite(flat)]
    if not flat.size:
        return -1.0, 1.0
    low, high = float(flat.min()), float(flat.max())
    pad = margin * (high - low) or 0.5
    return low - pad, high + pad


@styled
def save(figure: Figure, stem: Path) -> tuple[Path, Path]:
    """Write a figure as STEM.png (200 dpi) and STEM.pdf (vectors, fonts embedded).

    The layout is solved once and both files take it, so they look alike and the second costs little.
    """
    picture, document = stem.with_suffix(".png"), stem.with_suffix(".pdf")
    figure.savefig(picture, dpi=DPI, pil_kwargs={"compress_level": 4})
    figure.set_layout_engine(None)
    figure.savefig(document, metadata={"CreationDate": None})
    return picture, document
