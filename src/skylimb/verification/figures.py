"""One figure for each row."""

from __future__ import annotations

from pathlib import Path

from skylimb.verification.row import Evidence

_COLORS = [
    "#0072b2",
    "#d55e00",
    "#009e73",
    "#cc79a7",
    "#e69f00",
    "#56b4e9",
    "#000000",
]  # told apart by everyone


def write_figure(evidence: Evidence, path: Path) -> str:
    """Draw the evidence into a PNG file; returns the file's name."""
    import matplotlib as mpl
    from cycler import cycler
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    style = {
        "axes.prop_cycle": cycler(color=_COLORS),
        "axes.spines.top": False,
        "axes.spines.right": False,
        "font.size": 9,
        "legend.fontsize": 7,
        "legend.frameon": False,
    }
    with mpl.rc_context(style):  # type: ignore[arg-type]
        figure = Figure(figsize=(5.0, 3.2), layout="constrained", dpi=140)
        FigureCanvasAgg(figure)
        axes = figure.add_subplot()
        evidence.draw(axes)
        row = evidence.row
        axes.set_title(
            f"{row.name.replace('_', ' ')}: {'holds' if row.passed else 'FAILS'}", loc="left", fontsize=9
        )
        figure.savefig(path, metadata={"Software": None})
    return path.name
