"""The one look of every figure: sizes, fonts, colours, and how a figure is saved.

Figures are built on matplotlib's objects alone, so that no window, backend or global state of the caller's is
touched.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import matplotlib
import numpy as np
from cycler import cycler
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from skylimb.analysis.figures.fonts import families
from skylimb.analysis.figures.palette import CONTROLLER_COLOURS, CURVES, colours, colours_of, label
from skylimb.analysis.recording import Run
from skylimb.base.files import replacing

__all__ = ["CONTROLLER_COLOURS", "colours", "colours_of", "label"]

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")

WIDTH = 7.16
"""Inches: the full width of a two-column journal page."""

DPI = 200
POINTS = 600
"""A line is drawn through at most about this many samples; more would not show at this size."""

MOST_SIGNS = 6
"""Colours that a sign in a legend shows side by side, at most."""

REFERENCE = "#555555"
TRUTH = "#9A9A9A"
CONTACT = "#FBEFB5"
ADAPTATION = "#F8D5E2"
LOST = "#C9DDF0"
DARK = "#1A1A1A"
FAILURE = "#B00020"

DASHED = (0, (4, 2.5))
AS_REFERENCE: dict[str, Any] = {"color": REFERENCE, "linestyle": DASHED, "linewidth": 0.9}
"""How the line of a reference is drawn."""

RC: dict[Any, Any] = {
    "font.family": "sans-serif",
    "font.size": 8,
    "axes.titlesize": 8.5,
    "axes.titleweight": "bold",
    "axes.labelsize": 8,
    "axes.linewidth": 0.6,
    "axes.edgecolor": "#444444",
    "axes.labelcolor": DARK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": False,
    "axes.prop_cycle": cycler(color=CURVES),
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.color": DARK,
    "ytick.color": DARK,
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


def title(ax: Axes, name: str, run: Run) -> None:
    """Head a panel with the run's name; a flight that was lost or not finished says so."""
    ax.set_title(marked(name, run), color=FAILURE if run.failed else DARK)


def marked(name: str, run: Run) -> str:
    """The name of a run as figures show it, with what became of it where it failed."""
    return f"{label(name)} ({run.mark})" if run.failed else label(name)


def thin(count: int, points: int = POINTS) -> slice:
    """A slice that keeps about `points` of `count` samples."""
    return slice(None, None, max(1, count // points))


def panels(count: int, most: int = 4) -> tuple[int, int]:
    """Rows and columns for `count` panels, at most `most` beside each other and the rows equally full."""
    rows = -(-count // most)
    return rows, -(-count // rows)


def sheet(
    height: float, rows: int = 1, columns: int = 1, *, width: float = WIDTH, **settings: Any
) -> tuple[Figure, Any]:
    """A figure with panels, laid out without overlaps.

    Args:
        height: of the figure, inches.
        rows: of panels.
        columns: of panels.
        width: of the figure, inches.
        settings: of the panels, as `Figure.subplots` takes them.

    Returns:
        The figure and what `Figure.subplots` gives: one panel, or an array of them.
    """
    figure = Figure((width, height), layout="constrained")
    return figure, figure.subplots(rows, columns, **settings)


def swatch(colour: str, text: str) -> Patch:
    """A filled square for the legend."""
    return Patch(facecolor=colour, edgecolor="none", label=text)


def in_all_colours(runs: Mapping[str, Run], text: str, **line: Any) -> tuple[Line2D, ...]:
    """A legend's sign for curves that have the colour of their run: the line, or mark, in each colour."""
    return in_colours(list(colours(runs).values()), text, **line)


def in_colours(colours: Sequence[str], text: str, **line: Any) -> tuple[Line2D, ...]:
    """A legend's sign for curves of several colours: the line, or mark, in each."""
    return tuple(Line2D([], [], color=colour, label=text, **line) for colour in colours[:MOST_SIGNS])


def legend_below(figure: Figure, signs: Sequence[Artist | tuple[Line2D, ...]]) -> None:
    """One legend for the whole figure under the panels, in as few rows as its width allows.

    Args:
        figure: to draw on.
        signs: what stands for each kind of curve; of a tuple its parts stand side by side.
    """
    texts = [str((sign[0] if isinstance(sign, tuple) else sign).get_label()) for sign in signs]
    fitting = int(figure.get_figwidth() / (0.5 + 0.058 * max(map(len, texts))))  # inches, sign and letters
    columns = max(1, min(fitting, len(signs)))
    figure.legend(
        list(signs),  # pyright: ignore[reportArgumentType]  # tuples have a handler below
        texts,
        loc="outside lower center",
        ncols=columns,
        handlelength=2.4 if any(isinstance(sign, tuple) and len(sign) > 1 for sign in signs) else 1.8,
        handler_map={tuple: HandlerTuple(ndivide=None, pad=0.15)},
    )


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


def as_wide(limits: tuple[float, float], span: float) -> tuple[float, float]:
    """Limits with the same middle that span at least so much."""
    middle, half = 0.5 * sum(limits), 0.5 * max(span, limits[1] - limits[0])
    return middle - half, middle + half


@styled
def save(figure: Figure, stem: Path) -> tuple[Path, Path]:
    """Write a figure as STEM.png (200 dpi) and STEM.pdf (vectors, fonts embedded), each in one step.

    The layout is solved once and both files take it, so they look alike and each is drawn once.

    Raises:
        OSError: when a file cannot be written.
    """
    picture, document = stem.with_suffix(".png"), stem.with_suffix(".pdf")
    with replacing(picture, durable=False) as aside:
        aside.write_bytes(png(figure))
    with replacing(document, durable=False) as aside:
        figure.savefig(aside, format="pdf", metadata={"CreationDate": None})
    return picture, document


@styled
def png(figure: Figure, dpi: float | None = None) -> bytes:
    """A figure as PNG. Its layout is solved here, and stays as it is from then on."""
    figure.set_dpi(dpi or DPI)  # letters are not equally wide at every resolution
    engine = figure.get_layout_engine()
    if engine is not None:
        # Matplotlib would solve it twice, and draw the figure once more in between.
        engine.execute(figure)
        figure.set_layout_engine(None)
    picture = io.BytesIO()
    figure.savefig(
        picture, format="png", dpi=dpi or DPI, metadata={"Software": None}, pil_kwargs={"compress_level": 4}
    )
    return picture.getvalue()
