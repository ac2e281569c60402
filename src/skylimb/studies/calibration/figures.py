"""The figures of a calibration's report."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from skylimb.analysis.figures import style
from skylimb.studies.calibration.parameters import centers, scaled, spreads
from skylimb.studies.calibration.result import SIGMAS, Calibration

_DPI = 150


@style.styled
def write_figures(made: Calibration, folder: Path) -> dict[str, str]:
    """Write every figure as a PNG file; returns what each shows, by file name."""
    drawn = {
        "intervals.png": (_intervals(made), "95 % intervals after the flight, over those before it"),
        "residuals.png": (
            _residuals(made),
            "What the frames differ from their prediction, over the noise that is expected, before and after",
        ),
        "information.png": (
            _information(made),
            "The map of information: each direction of the parameters, best shown first. A standard "
            "deviation of 1 is the accuracy that is wanted",
        ),
        "correlations.png": (_correlations(made), "Correlations of the estimate"),
    }
    for name, (figure, _) in drawn.items():
        (folder / name).write_bytes(style.png(figure, _DPI))
    return {name: caption for name, (_, caption) in drawn.items()}


def _intervals(made: Calibration) -> Figure:
    """Each entry's interval, beside that of the prior and the truth, over the prior's standard deviation."""
    estimate = made.estimate
    center, spread = centers(estimate.parameters), spreads(estimate.parameters)
    rows = np.arange(len(center))[::-1]
    figure, axes = style.sheet(4.2)
    axes.hlines(rows, -SIGMAS, SIGMAS, color="#DDDDDD", linewidth=7, label="believed before")
    middle = (estimate.value - center) / spread
    half = SIGMAS * estimate.deviation / spread
    axes.errorbar(
        middle, rows, xerr=half, fmt="o", color=style.CURVES[0], markersize=3, capsize=3, label="estimate"
    )
    if made.truth is not None:
        axes.plot((made.truth - center) / spread, rows, "x", color=style.CURVES[1], label="truth")
    axes.set_yticks(rows, estimate.labels)
    axes.set_xlabel("less what was believed, over its standard deviation")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)
    return figure


def _residuals(made: Calibration) -> Figure:
    estimate = made.estimate
    figure, grid = style.sheet(3.6, 2, 2, sharex=True, sharey="row")
    for column, (title, values) in enumerate((("before", estimate.before), ("after", estimate.after))):
        for row, (what, part) in enumerate((("place", slice(0, 3)), ("attitude", slice(3, 6)))):
            axes = grid[row][column]
            axes.plot(estimate.times, values[:, part], ".", markersize=0.8)
            size = float(np.sqrt(np.mean(values[:, part] ** 2)))
            axes.set_title(f"{what}, {title}: rms {size:.2f}", loc="left")
            if column == 0:
                axes.set_ylabel("residual / noise")
    for axes in grid[1]:
        axes.set_xlabel("time, s")
    return figure


def _information(made: Calibration) -> Figure:
    """Eigenvectors of the scaled information, and the standard deviation along each."""
    estimate = made.estimate
    values, vectors = np.linalg.eigh(scaled(estimate.information, estimate.parameters))
    order = np.argsort(values)[::-1]
    deviations = 1.0 / np.sqrt(np.maximum(values[order], 1e-12))
    figure, (above, below) = style.sheet(4.4, 2, 1, sharex=True, height_ratios=(1, 2.4))
    at = np.arange(len(values))
    above.bar(at, deviations, color=style.CURVES[0])
    above.axhline(1.0, color=style.DARK, linewidth=0.8, linestyle=":")
    above.set_yscale("log")
    above.set_ylabel("std / wanted")
    drawn = below.imshow(np.abs(vectors[:, order]), cmap="Blues", vmin=0.0, vmax=1.0, aspect="auto")
    wanted = [
        f"{label} ({f'{one.wanted:g} {one.unit}'.strip()})"
        for one in estimate.parameters
        for label in one.labels
    ]
    below.set_yticks(np.arange(len(wanted)), wanted)
    below.set_xticks(at, [str(i + 1) for i in at])
    below.set_xlabel("direction, best shown first; in brackets the accuracy that is wanted")
    figure.colorbar(drawn, ax=below, label="part of the direction")
    return figure


def _correlations(made: Calibration) -> Figure:
    estimate = made.estimate
    figure, axes = style.sheet(4.6, width=0.8 * style.WIDTH)
    drawn = axes.imshow(estimate.correlation, cmap="RdBu_r", vmin=-1.0, vmax=1.0)
    at = np.arange(len(estimate.labels))
    axes.set_yticks(at, estimate.labels)
    axes.set_xticks(at, estimate.labels, rotation=90)
    figure.colorbar(drawn, ax=axes)
    return figure
