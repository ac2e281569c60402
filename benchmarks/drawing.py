"""What the preset `drawing` draws: four drawings by a robot that knows itself, one by 50 that do not.

    python benchmarks/drawing.py [--draws 50] [--part known | unknown] [--minutes 60] [--tables]

**known**: examples/skylimb.svg 0.6 m wide, a star of 0.12 m, a circle of 25 mm and the word skylimb 40 mm
high, on the paper's board, seeds 0 to 3. **unknown**: examples/skylimb.svg with the robots, boards and
frictions of the draws of benchmarks/following.py, each without and with the calibration that
docs/calibration.json keeps of the same draw (its error is put on top of the truth; the calibration is not
flown again). All at 0.05 m/s, as `skylimb draw` does. docs/drawing.json keeps every flight, a line each; one
that it holds is not flown again. The tables of docs/reports/drawing.md are written anew.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.pen_line import drawn_samples
from skylimb.analysis.scores.strokes import lifted, stroke_begins
from skylimb.control.corrections import Corrections
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import take_off

sys.path.insert(0, str(Path(__file__).parent))
from calibration import kept_corrections  # beside this file, as the next two
from following import draws
from kept import fill, keep

HERE = Path(__file__).parent
DOCS = HERE.parent / "docs"
PAGE, NUMBERS = DOCS / "reports" / "drawing.md", DOCS / "drawing.json"
SEEDS = (0, 1, 2, 3)
PEN: Mapping[str, Any] = {
    "trajectory.shape": "drawing",
    "trajectory.speed": 0.05,
    "trajectory.acceleration": 0.05,
    "trajectory.feedforward": "full",
}
DRAWINGS: Mapping[str, Mapping[str, Any]] = {
    "skylimb.svg": {
        "trajectory.file": str(HERE.parent / "examples" / "skylimb.svg"),
        "trajectory.width": 0.6,
    },
    "star": {"trajectory.file": str(HERE / "drawings" / "star.svg"), "trajectory.width": 0.12},
    "circle": {"trajectory.file": str(HERE / "drawings" / "circle.svg"), "trajectory.width": 0.025},
    "text": {"trajectory.text": "skylimb", "trajectory.height": 0.04, "trajectory.width": 0.0},
}
TITLES = {
    "skylimb.svg": "`examples/skylimb.svg`, 0.6 m",
    "star": "star of 0.12 m",
    "circle": "circle of 25 mm",
    "text": "the word skylimb, 40 mm high",
}
WANTED = {"skylimb.svg": 5.0, "star": 4.0, "circle": 4.0, "text": 4.0}


def tails(run: Run) -> Iterator[float]:
    """How far the pen went while it still touched after each lift began, m; 0 where it left at once."""
    samples, points = drawn_samples(run.log)
    begins = np.flatnonzero(np.diff(lifted(run.log).astype(np.int8), prepend=0) == 1)
    for begin, end in zip(begins, stroke_begins(run.log)[1:], strict=True):
        tail = points[(samples >= begin) & (samples < end)]
        yield float(np.linalg.norm(tail - tail[0], axis=1).max()) if len(tail) else 0.0


def scores(run: Run) -> dict[str, Any]:
    """How well one was drawn: mm, and shares."""
    if run.failed:
        return {"lost": run.cause}
    found = run.metrics
    return {
        "lost": "",
        "rms": 1e3 * float(found["pen_line_rms"]),
        "frechet": 1e3 * float(found["line_frechet"] if found["line_frechet"] is not None else np.inf),
        "tail": 1e3 * max(tails(run), default=0.0),
        "lift_touch": float(found["checks"].get("lifted", {"value": 0.0})["value"]),
        "force_std": float(found["contact_force_normal_std"]),
        "missed": ", ".join(name for name, check in found["checks"].items() if not check["kept"]),
    }


def known() -> Iterator[dict[str, Any]]:
    """Every drawing with every seed."""
    for name in DRAWINGS:
        for seed in SEEDS:
            yield {"part": "known", "drawing": name, "seed": seed}


def unknown(count: int) -> Iterator[dict[str, Any]]:
    """Every draw, without and with its calibration."""
    for number in range(count):
        for calibrated in (False, True):
            yield {"part": "unknown", "draw": number, "calibrated": calibrated}


def flown(cell: Mapping[str, Any], drawn: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """One flight, and what it drew."""
    if cell["part"] == "known":
        changes = {**PEN, **DRAWINGS[cell["drawing"]]}
        return {**cell, **scores(fly(cell["seed"], changes))}
    one = {key: value for key, value in drawn[cell["draw"]].items() if key != "trajectory.direction"}
    changes = {**PEN, **DRAWINGS["skylimb.svg"], **one}
    given = kept_corrections(cell["draw"], one) if cell["calibrated"] else None
    run = fly(None, changes, given)
    board = {"slope": float(np.degrees(one["surface.slope"])), "friction": one["surface.friction"]}
    return {**cell, **board, **scores(run)}


def fly(seed: int | None, changes: Mapping[str, Any], calibration: Corrections | None = None) -> Run:
    """One flight on the native driver, which a flight of four minutes is worth."""
    (takeoff,) = take_off("paper", ("drawing",), seed, changes, calibration=calibration)
    return scored_run(takeoff, fly_native([takeoff])[0])


def known_table(rows: Sequence[Mapping[str, Any]]) -> str:
    """The range of the seeds, a drawing a line."""
    lines = [
        "| drawing | pen off its line, rms | Frechet distance | wanted | longest tail | lifts in touch "
        "| done |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, title in TITLES.items():
        own = [row for row in rows if row["part"] == "known" and row["drawing"] == name]
        if not own:
            continue
        if any(row["lost"] for row in own):
            lines.append(
                f"| {title} | {sum(bool(row['lost']) for row in own)} of {len(own)} lost | | | | | |"
            )
            continue
        lifts = len({row["tail"] for row in own}) > 1
        lines.append(
            f"| {title} | {spread(own, 'rms')} mm | {spread(own, 'frechet')} mm | {WANTED[name]:g} mm | "
            + (f"{spread(own, 'tail')} mm | {spread(own, 'lift_touch', 100.0)} % |" if lifts else "- | - |")
            + f" {done(own)} |"
        )
    return "\n".join(lines)


def done(rows: Sequence[Mapping[str, Any]]) -> str:
    """How many were done as commanded, and what the others missed."""
    missed = [name for row in rows if not row["lost"] for name in row["missed"].split(", ") if name]
    kept = sum(not row["lost"] and not row["missed"] for row in rows)
    causes = [f"{name} {count}" for name, count in Counter(missed).most_common()]
    return f"{kept} of {len(rows)}" + (f" ({', '.join(causes)})" if causes else "")


def spread(rows: Sequence[Mapping[str, Any]], key: str, scale: float = 1.0) -> str:
    """Least and largest of the rows."""
    values = [scale * row[key] for row in rows]
    return f"{min(values):.1f} .. {max(values):.1f}"


def unknown_table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Median and worst decile, without and with a calibration."""
    own = [row for row in rows if row["part"] == "unknown"]
    pairs = [[row for row in own if row["calibrated"] is which] for which in (False, True)]
    count = min(map(len, pairs))
    if not count:
        return "No draw has been flown."
    lines = [
        f"| {count} draws, median / worst decile | without | with the calibration | wanted |",
        "|---|---|---|---|",
    ]
    for title, key, unit, scale, wanted in (
        ("pen off its reference, rms", "rms", "mm", 1.0, "3 mm"),
        ("Frechet distance", "frechet", "mm", 1.0, "8 mm"),
        ("longest tail", "tail", "mm", 1.0, "5 mm"),
        ("lifts in touch", "lift_touch", "%", 100.0, ""),
        ("standard deviation of the force", "force_std", "N", 1.0, ""),
    ):
        cells = []
        for part in pairs:
            values = [scale * row[key] for row in part if not row["lost"]]
            cells.append(
                f"{np.median(values):.2g} / {np.percentile(values, 90):.2g} {unit}" if values else "-"
            )
        lines.append(f"| {title} | {' | '.join(cells)} | {wanted} |")
    lost = [f"{sum(bool(row['lost']) for row in part)} of {len(part)}" for part in pairs]
    kept = [done(part) for part in pairs]
    return "\n".join(
        [*lines, f"| lost | {' | '.join(lost)} | 0 |", f"| done as commanded | {' | '.join(kept)} | |"]
    )


def write_tables(rows: Sequence[Mapping[str, Any]]) -> None:
    """Put the tables into the page."""
    fill(PAGE, "known", known_table(rows))
    fill(PAGE, "unknown", unknown_table(rows))


def main() -> None:
    """Fly what is missing, keep it, write the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--draws", type=int, default=50)
    parser.add_argument("--part", choices=("known", "unknown"), help="fly one part only")
    parser.add_argument("--minutes", type=float, default=60.0, help="begin no more flights after so long")
    parser.add_argument("--tables", action="store_true", help="fly nothing: the tables of docs/drawing.json")
    options = parser.parse_args()
    rows = json.loads(NUMBERS.read_text(encoding="utf-8")) if NUMBERS.exists() else []
    cells = [] if options.tables else [*known(), *unknown(options.draws)]
    drawn, began = list(draws("paper", options.draws)), time.monotonic()
    for cell in cells:
        if options.part not in (None, cell["part"]) or any(cell.items() <= row.items() for row in rows):
            continue
        if time.monotonic() - began > 60.0 * options.minutes:
            break
        rows.append(flown(cell, drawn))
        keep(NUMBERS, rows)
        print(len(rows), rows[-1], flush=True)
    write_tables(rows)
    print(known_table(rows), unknown_table(rows), sep="\n\n")


if __name__ == "__main__":
    main()
