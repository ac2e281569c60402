"""Runs every row and writes its figures and one page."""

from __future__ import annotations

import dataclasses
import html
import json
from collections.abc import Callable
from pathlib import Path

from skylimb.recording.files import new_folder, require_new
from skylimb.verification import impact, invariance, sliding, statics, stick_slip
from skylimb.verification.row import Evidence, Row

ROWS: tuple[Callable[[], Evidence], ...] = (
    statics.slip_angle,
    sliding.kinetic_friction,
    statics.static_indentation,
    sliding.sliding_indentation,
    statics.creep,
    impact.restitution,
    impact.energy,
    sliding.kept_contact,
    invariance.impulse_balance,
    invariance.convergence,
    invariance.moving_wall,
    invariance.placement,
    invariance.geometry,
    sliding.friction_map,
    stick_slip.stick_slip,
    statics.adhesion,
)
"""Every claim, in the order of the page."""


def verify_contact(
    out: Path | None = None, progress: Callable[[int, int, str], None] | None = None
) -> list[Row]:
    """Measure the contact against theory.

    Args:
        out: a folder that does not exist yet, for `contact.html`, `rows.json` and a figure of each row.
        progress: called with the number of rows done, of all rows, and the name of the next one.

    Returns:
        The rows; the contact is verified when every one has `passed`.

    Raises:
        OutputError: the folder exists already, or cannot be written.
    """
    if out is not None:
        out = require_new(out)
    evidence = []
    for index, measure in enumerate(ROWS):
        if progress is not None:
            progress(index, len(ROWS), measure.__name__)
        evidence.append(measure())
    if progress is not None:
        progress(len(ROWS), len(ROWS), "")
    if out is None:
        return [item.row for item in evidence]
    return _write(evidence, out)


def _write(evidence: list[Evidence], out: Path) -> list[Row]:
    from skylimb.verification.figures import write_figure

    with new_folder(out) as folder:
        rows = [
            dataclasses.replace(item.row, figure=write_figure(item, folder / f"{item.row.name}.png"))
            for item in evidence
        ]
        records = [dataclasses.asdict(row) | {"passed": row.passed} for row in rows]
        (folder / "rows.json").write_text(json.dumps(records, indent=2) + "\n", encoding="utf-8")
        (folder / "contact.html").write_text(page(rows), encoding="utf-8")
    return rows


_STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #222; }
body { margin: 2rem auto; max-width: 64rem; padding: 0 1rem; }
table { border-collapse: collapse; width: 100%; } th, td { text-align: left; padding: .3rem .6rem; }
tr { border-bottom: 1px solid #ddd; } .failed { color: #b00; font-weight: bold; }
figure { display: inline-block; width: 48%; margin: .5rem .4%; vertical-align: top; } img { width: 100%; }
figcaption { font-size: 85%; }
"""


def page(rows: list[Row]) -> str:
    """One page of HTML with the table and the figures, which lie beside it."""
    passed = sum(row.passed for row in rows)
    lines = [
        "<!doctype html><html lang='en'><head><meta charset='utf-8'>",
        f"<title>Contact against theory</title><style>{_STYLE}</style></head><body>",
        "<h1>Contact against theory</h1>",
        f"<p>{passed} of {len(rows)} claims hold.</p>",
        "<table><tr><th>Claim</th><th>Measured</th><th>Theory</th><th>Tolerance</th>"
        "<th>Cases</th><th></th></tr>",
    ]
    for row in rows:
        verdict = "holds" if row.passed else "<span class='failed'>fails</span>"
        bound = {"": "", "below": "at most ", "above": "at least "}[row.bound]
        lines.append(
            f"<tr><td>{html.escape(row.claim)}</td><td>{row.measured:.5g} {html.escape(row.unit)}</td>"
            f"<td>{bound}{row.theory:.5g}</td><td>{row.tolerance:g}</td><td>{row.cases}</td><td>{verdict}</td></tr>"
        )
    lines.append("</table>")
    for row in rows:
        if row.figure is not None:
            claim = html.escape(row.claim)
            lines.append(
                f"<figure><img src='{row.figure}' alt='{claim}'><figcaption>{claim}</figcaption></figure>"
            )
    return "\n".join([*lines, "</body></html>", ""])
