"""A calibration's folder: the data, one page to read, its figures, and the flight it is made of."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from skylimb.analysis.pages.pages import inlined, render_page
from skylimb.analysis.recording.origin import write_sources
from skylimb.analysis.recording.run import LOG_FILE, Run
from skylimb.analysis.report.places import CALIBRATION_FILE
from skylimb.analysis.viewer.page import viewer_html
from skylimb.base.files import new_folder
from skylimb.control.calibration_date import dated
from skylimb.studies.calibration.figures import write_figures
from skylimb.studies.calibration.parameters import centers, spreads
from skylimb.studies.calibration.result import SIGMAS, Calibration

TEMPLATE = Path(__file__).with_name("report_template.html")
REPORT = "report.html"

STRONG = 0.9
"""Size of a correlation from which it is named."""

_SHOWN_IN = {"rad": ("mrad", 1e3, 2), "m": ("mm", 1e3, 2), "s": ("ms", 1e3, 2), "": ("%", 1e2, 3)} | {
    "m/s^2": ("m/s^2", 1.0, 4)
}
"""Unit that people read, its factor and its digits, by the SI unit."""


class Row(NamedTuple):
    """A line of the table, in words."""

    label: str
    value: str
    interval: str
    prior: str
    shown: bool
    truth: str = ""
    error: str = ""


def rows_of(made: Calibration) -> list[Row]:
    """Every entry as a person reads it."""
    estimate, (low, high) = made.estimate, made.interval
    center, around = centers(estimate.parameters), SIGMAS * spreads(estimate.parameters)
    units = [_SHOWN_IN[one.unit] for one in estimate.parameters for _ in one.labels]
    rows = []
    for i, (label, (unit, factor, digits)) in enumerate(zip(estimate.labels, units, strict=True)):
        row = Row(
            label,
            f"{factor * estimate.value[i]:.{digits}f} {unit}",
            f"{factor * low[i]:.{digits}f} .. {factor * high[i]:.{digits}f}",
            f"{factor * (center[i] - around[i]):.3g} .. {factor * (center[i] + around[i]):.3g}",
            bool(estimate.shown[i]),
        )
        if made.truth is not None:
            error = (estimate.value[i] - made.truth[i]) / estimate.deviation[i]
            row = row._replace(truth=f"{factor * made.truth[i]:.{digits}f}", error=f"{error:+.1f}")
        rows.append(row)
    return rows


def correlated(made: Calibration) -> list[str]:
    """Pairs of entries whose correlation is strong, in words."""
    matrix, labels = made.estimate.correlation, made.estimate.labels
    return [
        f"{labels[i]} and {labels[j]} ({matrix[i, j]:+.2f})"
        for i in range(len(labels))
        for j in range(i)
        if abs(matrix[i, j]) > STRONG
    ]


def write_calibration(made: Calibration, folder: str | Path, flown: Run | None = None) -> Path:
    """Write `calibration.toml`, `report.html` and the figures into a new folder.

    Args:
        made: the calibration.
        folder: it must not exist.
        flown: the flight, whose log.nc and files are kept beside them, and which the report shows again.

    Returns:
        The folder.

    Raises:
        OutputError: if it exists or cannot be written; nothing is left behind then.
    """
    with new_folder(folder) as staging:
        (staging / CALIBRATION_FILE).write_text(dated(made.text), encoding="utf-8")
        if flown is not None:
            flown.save(staging / LOG_FILE)
            write_sources(flown.sources, staging)
        figures = staging / "figures"
        figures.mkdir()
        captions = write_figures(made, figures)
        (staging / REPORT).write_text(_page(made, figures, captions, flown), encoding="utf-8")
    return Path(folder)


def _page(made: Calibration, figures: Path, captions: dict[str, str], flown: Run | None) -> str:
    estimate, flight = made.estimate, made.flight
    before = float(np.sqrt(np.mean(estimate.before**2)))
    unfollowed = (
        f" Another {flight['seconds_unfollowed']:g} s, in which motors could not follow what was commanded, "
        "are not used: their thrusts are not known."
        if flight["seconds_unfollowed"]
        else ""
    )
    return render_page(
        TEMPLATE,
        title=f"Calibration of {made.robot}",
        verdict=made.verdict,
        flight=(
            f"From {flight['seconds']:g} s of '{flight['experiment']}' flown by '{flight['controller']}', "
            f"{flight['frames']} frames of the motion capture ({flight['frames_left_out']} left out). What a "
            f"frame differs from its prediction was {before:.2f} times the noise with what was believed "
            f"before, and is {made.left:.2f} times with the estimate.{unfollowed}"
        ),
        rows=rows_of(made),
        with_truth=made.truth is not None,
        correlated=correlated(made),
        strong=STRONG,
        moved=made.moved,
        viewer=viewer_html({flown.name: flown}) if flown is not None else "",
        figures=[(inlined(figures / name, "image/png"), caption) for name, caption in captions.items()],
        versions=dict(made.versions),
    )
