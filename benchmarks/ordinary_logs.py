"""What a calibration finds in the logs of ordinary flights, and whether its intervals hold the truth.

    python benchmarks/ordinary_logs.py [--share 1.0] [--tables]

200 flights that nobody flew for a calibration, and 100 more that show little (a hover, a few seconds, slow
ticks) or what the model lacks (drag), by robots that do not know themselves: the draws of
benchmarks/following.py with another seed, for which nothing was tuned. Each log is calibrated from, and one
that draws a line is flown again with what was found. docs/ordinary_logs.json keeps a line a flight, and one
that it holds is not flown again; the table of docs/reports/calibration.md is written anew.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from following import draws  # beside this file, as the next one
from kept import fill, keep

import skylimb
from skylimb.base.errors import SkylimbError
from skylimb.robots.loader import load_robot
from skylimb.studies.calibration.parameters import parameters
from skylimb.studies.calibration.public import calibration_from
from skylimb.studies.calibration.result import SIGMAS

DOCS = Path(__file__).parents[1] / "docs"
PAGE, NUMBERS = DOCS / "reports" / "calibration.md", DOCS / "ordinary_logs.json"
SEED = 5100
LINE = "pen_line_rms"


@dataclass(frozen=True)
class Log:
    """A kind of log.

    Attributes:
        experiment: that is flown.
        controller: that flies it.
        flights: how many.
        changes: to the experiment, besides those that are drawn.
        part: of it that is calibrated from, s; all of it without.
    """

    experiment: str
    controller: str
    flights: int
    changes: Mapping[str, Any] = field(default_factory=dict)
    part: tuple[float, float] | None = None


LOGS = {
    "`paper` by `following`": Log("paper", "following", 80),
    "`push_and_slide` by `following`": Log("push_and_slide", "following", 40),
    "`writing` by `drawing`": Log("writing", "drawing", 40),
    "`free_flight` by `hybrid`": Log("free_flight", "hybrid", 40),
    "`paper`, drag of 0.3 1/s": Log("paper", "following", 20, {"plant.rotor_drag": 0.3}),
    "`free_flight`, 12.5 s of it": Log("free_flight", "hybrid", 20, part=(0.0, 12.5)),
    "a hover of 20 s": Log("free_flight", "hybrid", 20, {"phases.hover": 20.0, "stop_at": 20.0}),
    "`calibration`, 5 s of it": Log("calibration", "hybrid", 20, part=(10.0, 15.0)),
    "`calibration` at 50 Hz": Log("calibration", "hybrid", 20, {"controller_rate": 50.0}),
}


def one(kind: Log, drawn: Mapping[str, Any]) -> dict[str, Any]:
    """Errors over standard deviations from a flight's log, and its line without and with what was found."""
    own = ("plant.", "sensors.", "seed", *(("surface.", "trajectory.") if kind.experiment == "paper" else ()))
    changes = {key: value for key, value in drawn.items() if key.startswith(own)} | dict(kind.changes)
    flown = skylimb.run(kind.experiment, kind.controller, set=changes)
    row: dict[str, Any] = {"lost": _lost(flown)}
    if flown.failed:
        return row
    if kind.part:
        flown = replace(flown, log=flown.log.sel(time=slice(*kind.part)))
    try:
        made = calibration_from(flown, load_robot("hydrus_xi_quad"))
    except SkylimbError as error:
        return row | {"refused": str(error)}
    assert made.truth is not None
    off = (made.estimate.value - made.truth) / made.estimate.deviation
    row |= {"off": [round(float(value), 3) for value in off], "shown": int(np.sum(made.estimate.shown))}
    if kind.part or flown.metrics.get(LINE) is None:
        return row
    again = skylimb.run(kind.experiment, kind.controller, set=changes, calibration=made)
    return row | {
        "without": flown.metrics[LINE],
        "with": again.metrics.get(LINE),
        "lost with": _lost(again),
    }


def table(rows: Sequence[Mapping[str, Any]]) -> str:
    """A line for each kind of log."""
    labels = [label for one_of in parameters(load_robot("hydrus_xi_quad")) for label in one_of.labels]
    lines = [
        "| log | flights | refused | numbers shown | intervals that hold the truth: all, latency, "
        "the one that holds least | farthest, in standard deviations | line, rms mm, without | with |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name in LOGS:
        own = [row for row in rows if row["log"] == name]
        made = [row for row in own if "off" in row]
        if not made:
            continue
        off = np.abs(np.array([row["off"] for row in made]))
        holds = np.mean(off < SIGMAS, axis=0)
        least, (draw, far) = int(np.argmin(holds)), np.unravel_index(int(np.argmax(off)), off.shape)
        both = [row for row in made if row.get("with") is not None]
        cells = [
            name,
            f"{len(own)}",
            f"{sum('refused' in row for row in own)}",
            f"{np.median([row['shown'] for row in made]):.0f} of {off.shape[1]}",
            f"{100.0 * np.mean(holds):.1f} %, {100.0 * holds[labels.index('latency')]:.0f} %, "
            f"{100.0 * holds[least]:.0f} % (`{labels[least]}`)",
            f"{off[draw, far]:.1f} (`{labels[far]}`)",
            *(_line([row[key] for row in both]) for key in ("without", "with")),
        ]
        lines.append("| " + " | ".join(cells) + " |")
    lost = [sum(bool(row.get(key)) for row in rows) for key in ("lost", "lost with")]
    return "\n".join(
        [*lines, "", f"Of {len(rows)} flights {lost[0]} were lost, and {lost[1]} with a calibration."]
    )


def _lost(flown: skylimb.Run) -> str:
    """Why; a flight that its experiment stops early is none."""
    return (flown.cause or "") if flown.failed else ""


def _line(values: Sequence[float]) -> str:
    """Median and worst decile, mm."""
    return " / ".join(f"{1e3 * x:.3g}" for x in np.percentile(values, [50, 90])) if values else "-"


def main() -> None:
    """Fly what is missing, keep it, write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--share", type=float, default=1.0, help="of the flights of each kind")
    parser.add_argument("--tables", action="store_true", help="fly nothing")
    options = parser.parse_args()
    rows: list[dict[str, Any]] = json.loads(NUMBERS.read_text(encoding="utf-8")) if NUMBERS.exists() else []
    known = {(row["log"], row["draw"]) for row in rows}
    for name, kind in () if options.tables else LOGS.items():
        for number, drawn in enumerate(draws("paper", round(options.share * kind.flights), SEED)):
            if (name, number) not in known:
                rows.append({"log": name, "draw": number, **one(kind, drawn)})
                keep(NUMBERS, rows)
                print(rows[-1], flush=True)
    fill(PAGE, "ordinary", table(rows))
    print(table(rows))


if __name__ == "__main__":
    main()
