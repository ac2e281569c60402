"""Fly the reproduction and write its section of docs/reports/results.md around pages/reproduction.md.

    python benchmarks/reproduction.py             (about ten minutes on two cores)
    python benchmarks/reproduction.py DIR         (takes the folder that `skylimb reproduce` left)

Leaves docs/reproduction.json, docs/images/reproduction/ and the section between the two marks, whose tables
come from that file.
"""

from __future__ import annotations

import json
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

from skylimb.analysis.scores.axis_names import PAPER
from skylimb.analysis.scores.registry import SCORES
from skylimb.studies.reproduction import reproduce

HERE = Path(__file__).parent
DOCS = HERE.parent / "docs"
RESULT = DOCS / "reproduction.json"
BEGIN, END = "<!-- begin of the reproduction -->", "<!-- end of the reproduction -->"
CONTROLLERS = ("pid", "impedance", "admittance", "hybrid")
STRONGEST = 3


def section() -> str:
    """The section's text, filled from the committed result."""
    result = json.loads(RESULT.read_text(encoding="utf-8"))
    text = (HERE / "pages" / "reproduction.md").read_text(encoding="utf-8").strip()
    tables = {
        "COMMAND": f"`{result['command']}`",
        "DRAWS": str(result["draws"]),
        "FLIGHTS": str(result["flights"]),
        "LOST": str(sum(entry["count"] for entry in result["failures"].values())),
        "INSIDE": f"{result['inside']['count']} of the {result['inside']['of']}",
        "NUMBERS_TABLE": _numbers(result),
        "CLAIMS_TABLE": _claims(result),
        "FAILURES_TABLE": _failures(result),
        "SENSITIVITY_TABLE": _sensitivity(result),
        "NEAREST_TABLE": _nearest(result),
        "RATIOS_TABLE": _ratios(result),
    }
    for place, content in tables.items():
        text = text.replace(f"@{place}@", content)
    return f"{BEGIN}\n\n{text}\n\n{END}"


def _numbers(result: dict[str, Any]) -> str:
    lines = [
        "| | PID | impedance | admittance | hybrid |",
        "|---|---|---|---|---|",
    ]
    for key in dict.fromkeys(number["metric"] for number in result["numbers"]):
        cells = []
        for number in (n for n in result["numbers"] if n["metric"] == key):
            digits = 2 if number["unit"] == "N" else 3
            ours = (
                f"{number['median']:.{digits}f} ({number['low']:.{digits}f} .. {number['high']:.{digits}f})"
            )
            if number["paper"] is None:
                cells.append(ours)
                continue
            verdict = "" if number["inside"] else ", **outside**"
            cells.append(f"*{number['paper']:.3f}*<br>{ours}<br>{number['percentile']:.0f} %{verdict}")
        score = SCORES[key]
        lines.append(f"| {_cell(score.text(PAPER))}, {score.unit} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _claims(result: dict[str, Any]) -> str:
    readings = list(result["claims"][0]["by_reading"])
    lines = [
        "| claim | formula | all draws | without loss | " + " | ".join(readings) + " |",
        "|---|---|---|---|" + "---|" * len(readings),
    ]
    for claim in result["claims"]:
        cells = [
            _cell(claim["text"]),
            f"`{claim['formula']}`".replace("|", "\\|"),
            _rate(claim["all_draws"]),
            _rate(claim["draws_without_loss"]),
            *(f"{100 * claim['by_reading'][name]['rate']:.0f} %" for name in readings),
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _rate(rate: dict[str, float]) -> str:
    return f"**{100 * rate['rate']:.0f} %** ({100 * rate['low']:.0f} .. {100 * rate['high']:.0f})"


def _failures(result: dict[str, Any]) -> str:
    told = []
    for name, entry in result["failures"].items():
        causes = "; ".join(f"{count} x {cause}" for cause, count in entry["causes"].items())
        told.append(f"- {name}: {entry['count']} of {result['draws']}{f' ({causes})' if causes else ''}")
    return "\n".join(told)


def _sensitivity(result: dict[str, Any]) -> str:
    lines = ["| number | moved most by (rank correlation) |", "|---|---|"]
    for column, unknowns in result["sensitivity"].items():
        name, _, key = column.partition(".")
        known = [(unknown, value) for unknown, value in unknowns.items() if value is not None]
        strongest = sorted(known, key=lambda entry: -abs(entry[1]))[:STRONGEST]
        told = ", ".join(f"`{_cell(unknown)}` {value:+.2f}" for unknown, value in strongest)
        lines.append(f"| {name}: {_cell(SCORES[key].text(PAPER))} | {told} |")
    return "\n".join(lines)


def _nearest(result: dict[str, Any]) -> str:
    lines = [
        "| draw | distance | y errors (m) | x displacements (m) | forces (N) | friction | press | reading |",
        "|---" * 8 + "|",
    ]
    for near in result["nearest"][:5]:
        rows = [
            " / ".join(f"{near['values'][name][key]:.{digits}f}" for name in CONTROLLERS)
            for key, digits in (
                ("error_u_median", 3),
                ("displacement_median", 3),
                ("estimated_force_median", 2),
            )
        ]
        given = near["parameters"]
        sent = "positions" if given["trajectory.feedforward"] == "none" else "velocities"
        tared = "tared" if given["controller.estimation.tare"] else "raw"
        lines.append(
            f"| {near['draw']} | {near['distance']:.2f} | {rows[0]} | {rows[1]} | {rows[2]} "
            f"| {given['surface.friction']:.2f} | {given['approach.depth']:.2f} m | {sent}, {tared} |"
        )
    return "\n".join(lines)


def _ratios(result: dict[str, Any]) -> str:
    lines = ["| ratio within a draw | paper | ensemble | percentile |", "|---|---|---|---|"]
    for entry in result["ratios"]:
        text = _cell(SCORES[entry["metric"]].text(PAPER))
        verdict = "" if entry["inside"] else ", **outside**"
        lines.append(
            f"| {text}: {entry['first']} / {entry['second']} | {entry['paper']:.2f} "
            f"| {entry['median']:.2f} ({entry['low']:.2f} .. {entry['high']:.2f}) "
            f"| {entry['percentile']:.0f} %{verdict} |"
        )
    return "\n".join(lines)


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def take(folder: Path) -> None:
    """Copy what a reproduction left into the documentation."""
    images = DOCS / "images" / "reproduction"
    images.mkdir(parents=True, exist_ok=True)
    for name in ("numbers", "claims", "sensitivity", "errata"):
        shutil.copyfile(folder / "figures" / f"{name}.png", images / f"{name}.png")
    shutil.copyfile(folder / "reproduction.json", RESULT)


def main(arguments: list[str]) -> None:
    if arguments:
        take(Path(arguments[0]))
    else:
        with tempfile.TemporaryDirectory() as temporary:
            reproduce(Path(temporary) / "reproduction")
            take(Path(temporary) / "reproduction")
    page = DOCS / "reports" / "results.md"
    text = page.read_text(encoding="utf-8")
    before, after = text[: text.index(BEGIN)], text[text.index(END) + len(END) :]
    page.write_text(before + section() + after, encoding="utf-8")


if __name__ == "__main__":  # worker processes import this file
    main(sys.argv[1:])
