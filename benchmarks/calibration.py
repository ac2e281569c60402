"""What `skylimb calibrate` reaches over random draws, and what it is worth to the preset `following`.

    python benchmarks/calibration.py [--draws 200] [--board-draws 200] [--minutes 60]
    python benchmarks/calibration.py --board

Draws are those of benchmarks/following.py: thrust +-2 % overall and per rotor, misaligned attitude +-1 degree
about each axis, mass +-1 %, centre of gravity +-10 mm along each axis, latency 10 .. 30 ms. Each is
calibrated by the experiment `calibration`, then flies the paper's board with and without its calibration.
docs/calibration.json keeps every number, a line a draw, and the tables of docs/reports/calibration.md are
written anew. Draws that it holds are not flown again: a run that was cut off goes on. `--board` flies the
board alone, with the calibrations that it holds: what they find does not depend on the gains of `following`,
and the board does. `--tables` flies nothing.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import skylimb
from skylimb.analysis.scores.registry import measured
from skylimb.base.errors import SkylimbError
from skylimb.control.corrections import Calibrated, Corrections
from skylimb.robots.loader import load_robot
from skylimb.studies.calibration.public import calibration_from
from skylimb.studies.calibration.result import SIGMAS

sys.path.insert(0, str(Path(__file__).parent))
from following import draws  # the same draws, beside this file
from kept import fill

DOCS = Path(__file__).parents[1] / "docs"
KEPT = DOCS / "calibration.json"
PLANT = ("plant.", "sensors.")
SCORES = {
    "pen_line_rms": ("pen line, rms", "mm", 1e3),
    "target_error_u_median": ("centre of gravity to its own target, y", "mm", 1e3),
    "target_error_v_median": ("the same, z", "mm", 1e3),
    "error_u_median": ("centre of gravity to the mission, y", "mm", 1e3),
    "error_v_median": ("the same, z", "mm", 1e3),
    "force_slow_std": ("force std, friction up to 0.8", "N", 1.0),
}
UNITS = {"rad": ("mrad", 1e3), "m": ("mm", 1e3), "s": ("ms", 1e3), "": ("%", 1e2), "m/s^2": ("mm/s^2", 1e3)}


def one(drawn: Mapping[str, Any], seed: int, fly: bool) -> dict[str, Any]:
    """Calibrate a draw; fly the paper's board without and with it."""
    robot = load_robot("hydrus_xi_quad")
    plant = {key: value for key, value in drawn.items() if key.startswith(PLANT)}
    flown = skylimb.run("calibration", seed=seed, set=plant)
    if flown.failed:
        return {"lost": flown.cause}
    try:
        made = calibration_from(flown, robot)
    except SkylimbError as error:
        return {"lost": str(error)}
    assert made.truth is not None
    found: dict[str, Any] = {
        "error": (made.estimate.value - made.truth).tolist(),
        "deviation": made.estimate.deviation.tolist(),
        "shown": made.estimate.shown.tolist(),
        "left": made.left,
    }
    return found | (on_board(drawn, made) if fly else {})


def on_board(drawn: Mapping[str, Any], made: Calibrated) -> dict[str, Any]:
    """Scores of the paper's board without and with a calibration."""
    found = dict[str, Any]()
    for name, calibration in (("without", None), ("with", made)):
        run = skylimb.run("paper", "following", set=dict(drawn), calibration=calibration)
        scores = {**run.metrics, **measured(run, ["contact"])}
        found[name] = {key: scores.get(key) for key in SCORES} | {"lost": run.cause}
    return found


def kept_corrections(number: int, drawn: Mapping[str, Any]) -> Corrections:
    """What the calibration of a draw found: the truth and the error that docs/calibration.json keeps."""
    robot = load_robot("hydrus_xi_quad")
    kept = json.loads(KEPT.read_text(encoding="utf-8"))[number]
    lag = float(np.mean([rotor.lag for rotor in robot.description.rotors]))
    scale = np.array(drawn["plant.rotor_scale"]) * drawn["plant.thrust_scale"] / drawn["plant.mass_scale"]
    first = [*drawn["sensors.attitude_misalignment"], *drawn["plant.cog_offset"], *scale]
    truth = np.array([*first, lag, drawn["sensors.latency"]])
    value = truth + np.array(kept["error"][: len(truth)])
    rotors = 6 + robot.n_rotors
    return Corrections(
        robot.name,
        robot.description.digest,
        tuple(value[0:3].tolist()),
        tuple(value[3:6].tolist()),
        tuple(value[6:rotors].tolist()),
        float(value[rotors]),
        float(value[rotors + 1]),
    )


def identification(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """A line for every parameter: error, wanted accuracy, coverage of the 95 % intervals."""
    from skylimb.studies.calibration.parameters import parameters

    kept = [row for row in rows if "error" in row]
    error = np.array([row["error"] for row in kept])
    deviation = np.array([row["deviation"] for row in kept])
    covered = np.mean(np.abs(error) < SIGMAS * deviation, axis=0)
    lines = [
        "| | error: median / worst decile | wanted | standard deviation | intervals that hold the truth |",
        "|---|---|---|---|---|",
    ]
    at = 0
    for one_of in parameters(load_robot("hydrus_xi_quad")):
        unit, factor = UNITS[one_of.unit]
        for label in one_of.labels:
            size = factor * np.abs(error[:, at])
            lines.append(
                f"| `{label}` | {np.median(size):.3g} / {np.percentile(size, 90):.3g} {unit} | "
                f"{factor * one_of.wanted:.3g} {unit} | "
                f"{factor * np.median(deviation[:, at]):.2g} {unit} | {100.0 * covered[at]:.0f} % |"
            )
            at += 1
    return lines


def following(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """What `following` reaches without and with the calibration."""
    kept = [row for row in rows if "with" in row]
    lines = [
        f"| `following` on the paper's board, {len(kept)} draws | without | with the calibration |",
        "|---|---|---|",
    ]
    for key, (title, unit, scale) in SCORES.items():
        cells = []
        for name in ("without", "with"):
            values = [row[name][key] for row in kept if row[name].get(key) is not None]
            if not values:
                break
            middle, worst = (scale * float(np.percentile(values, at)) for at in (50, 90))
            cells.append(f"{middle:.3g} / {worst:.3g} {unit}")
        if cells:
            lines.append(f"| {title} | {' | '.join(cells)} |")
    lost = [sum(bool(row[name]["lost"]) for row in kept) for name in ("without", "with")]
    lines.append(f"| lost flights | {lost[0]} of {len(kept)} | {lost[1]} of {len(kept)} |")
    return lines


def main() -> None:
    """Fly, keep, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--draws", type=int, default=200)
    parser.add_argument("--minutes", type=float, default=60.0, help="begin no draw after so long")
    parser.add_argument("--board-draws", type=int, default=200, help="draws that fly the board besides")
    parser.add_argument("--tables", action="store_true", help="fly nothing: tables of docs/calibration.json")
    parser.add_argument("--board", action="store_true", help="fly the board alone, with what is kept")
    options = parser.parse_args()
    rows: list[dict[str, Any]] = json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else []
    if options.board:
        for number, (row, drawn) in enumerate(zip(rows, draws("paper", len(rows)), strict=True)):
            if "with" in row:
                row.update(on_board(drawn, kept_corrections(number, drawn)))
                print(number, json.dumps(row["with"])[:100], flush=True)
        KEPT.write_text(compact(rows), encoding="utf-8")
    elif not options.tables:
        began = time.monotonic()
        for number, drawn in enumerate(draws("paper", options.draws)):
            if number < len(rows):
                continue
            if time.monotonic() - began > 60.0 * options.minutes:
                break
            rows.append(one(drawn, 1000 + number, number < options.board_draws))
            print(number, json.dumps(rows[-1])[:100], flush=True)
            KEPT.write_text(compact(rows), encoding="utf-8")
    write_tables(json.loads(KEPT.read_text(encoding="utf-8")))


def compact(rows: Sequence[Mapping[str, Any]]) -> str:
    """JSON with a line a draw and five digits a number."""

    def short(value: Any) -> Any:
        if isinstance(value, float):
            return float(f"{value:.5g}")
        if isinstance(value, list):
            return [short(entry) for entry in value]
        return {key: short(entry) for key, entry in value.items()} if isinstance(value, dict) else value

    return "[\n" + ",\n".join(json.dumps(short(dict(row))) for row in rows) + "\n]\n"


def write_tables(rows: Sequence[Mapping[str, Any]]) -> None:
    """Put the tables into the page."""
    lost = sum("lost" in row for row in rows)
    lines = [
        f"{len(rows)} draws; {lost} of their calibration flights were lost.",
        "",
        *identification(rows),
    ]
    if any("with" in row for row in rows):
        lines += ["", *following(rows)]
    fill(DOCS / "reports" / "calibration.md", "table", "\n".join(lines))


if __name__ == "__main__":
    main()
