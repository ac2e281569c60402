"""One figure for each row."""

from __future__ import annotations

from pathlib import Path

from skylimb.analysis.figures import style
from skylimb.studies.verification.row import Evidence

_DPI = 140


@style.styled
def write_figure(evidence: Evidence, path: Path) -> str:
    """Draw the evidence into a PNG file; returns the file's name."""
    figure, axes = style.sheet(3.2, width=5.0)
    evidence.draw(axes)
    row = evidence.row
    axes.set_title(f"{row.name.replace('_', ' ')}: {'holds' if row.passed else 'FAILS'}", loc="left")
    path.write_bytes(style.png(figure, _DPI))
    return path.name
