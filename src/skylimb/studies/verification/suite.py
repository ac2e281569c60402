"""Runs every row and writes its figures and one page."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable
from pathlib import Path

from skylimb.analysis.pages.pages import render_page
from skylimb.analysis.recording.versions import versions
from skylimb.base.files import new_folder, require_new
from skylimb.studies.verification import (
    foot,
    impact,
    invariance,
    peg,
    rotors,
    sliding,
    statics,
    stick_slip,
    valve,
)
from skylimb.studies.verification.row import Evidence, Row

TEMPLATE = Path(__file__).with_name("page_template.html")

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
    foot.foot_rocks,
    foot.foot_tips,
    foot.foot_slides,
    valve.valve_starts,
    valve.valve_turns,
    valve.valve_stops,
    valve.valve_step,
    peg.peg_sinks,
    peg.peg_balances,
    peg.peg_cone,
    peg.peg_chamfer,
    peg.peg_step,
)
"""Every claim about the contact, in the order of the page."""

_Progress = Callable[[int, int, str], None]


def verify_contact(out: Path | None = None, progress: _Progress | None = None) -> list[Row]:
    """Measure the contact against theory; see `_verify`."""
    return _verify("contact", ROWS, out, progress)


def verify_rotors(out: Path | None = None, progress: _Progress | None = None) -> list[Row]:
    """Measure rotors with a speed and an inertia against theory; see `_verify`."""
    return _verify("rotors", rotors.ROWS, out, progress)


def _verify(
    subject: str, claims: tuple[Callable[[], Evidence], ...], out: Path | None, progress: _Progress | None
) -> list[Row]:
    """Measure every claim about a subject.

    Args:
        subject: of the page.
        claims: each measures one.
        out: a folder that does not exist yet, for `SUBJECT.html`, `rows.json` and a figure of each row.
        progress: called with the number of rows done, of all rows, and the name of the next one.

    Returns:
        The rows; the subject is verified when every one has `passed`.

    Raises:
        OutputError: the folder exists already, or cannot be written.
    """
    if out is not None:
        out = require_new(out)
    evidence = []
    for index, measure in enumerate(claims):
        if progress is not None:
            progress(index, len(claims), measure.__name__)
        evidence.append(measure())
    if progress is not None:
        progress(len(claims), len(claims), "")
    if out is None:
        return [item.row for item in evidence]
    return _write(subject, evidence, out)


def _write(subject: str, evidence: list[Evidence], out: Path) -> list[Row]:
    from skylimb.studies.verification.figures import write_figure

    with new_folder(out) as folder:
        rows = [
            dataclasses.replace(item.row, figure=write_figure(item, folder / f"{item.row.name}.png"))
            for item in evidence
        ]
        records = [dataclasses.asdict(row) | {"passed": row.passed} for row in rows]
        (folder / "rows.json").write_text(json.dumps(records, indent=2) + "\n", encoding="utf-8")
        (folder / f"{subject}.html").write_text(_page(subject, rows), encoding="utf-8")
    return rows


def _page(subject: str, rows: list[Row]) -> str:
    """One page of HTML with the table and the figures, which lie beside it."""
    return render_page(
        TEMPLATE,
        title=f"{subject.capitalize()} against theory",
        rows=rows,
        bounds={"": "", "below": "at most ", "above": "at least "},
        passed=sum(row.passed for row in rows),
        versions=versions(),
    )
