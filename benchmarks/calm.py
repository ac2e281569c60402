"""From a calm force to a calm body: `following` on the paper's board over `shape.arm_share`.

    python benchmarks/calm.py [--draws 24] [--tables]

The draws of benchmarks/following.py. docs/calm.json keeps the scores of every flight, one line a setting, and
a setting that it holds is not flown again. The table between the markers of docs/reports/following_results.md
and docs/images/following_calm.png are made anew.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
from following import CHUNK, draws  # beside this file
from kept import fill
from matplotlib.figure import Figure

from skylimb.analysis.figures.style import styled
from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.registry import measured
from skylimb.control.contact.machine import SLIDE
from skylimb.control.controller import load_controller
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.experiments.experiment import load_experiment
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import prepare
from skylimb.robots.loader import load_robot

DOCS = Path(__file__).parents[1] / "docs"
PAGE, NUMBERS, FIGURE = (
    DOCS / "reports" / "following_results.md",
    DOCS / "calm.json",
    DOCS / "images" / "following_calm.png",
)
SHARES = (0.0, 0.15, 0.3, 0.45, 0.6, 0.8, 1.0)
SCORES = {
    "speed": ("body along the contact axis, rms mm/s", 1e3, 1),
    "way": ("its way, standard deviation mm", 1e3, 1),
    "rate": ("body rate, rms mrad/s", 1e3, 1),
    "force_std": ("force std N", 1.0, 3),
    "line": ("pen to line rms mm", 1e3, 1),
}


def scores(run: Run) -> dict[str, Any]:
    """How much body and force move while the pen slides; only the cause of a flight that was lost."""
    if run.failed:
        return {"lost": run.cause}
    log = run.log
    sliding = log.contact_state.values == SLIDE
    velocity = log.cog_velocity.values[sliding, 0]
    rate = log.angular_velocity_estimate.values[sliding]
    found = {**run.metrics, **measured(run, ["contact"])}
    return {
        "lost": "",
        "speed": float(np.sqrt(np.mean(velocity**2))),
        "way": float(np.std(log.cog_position.values[sliding, 0])),
        "rate": float(np.sqrt(np.mean(np.sum(rate**2, axis=1)))),
        "force_std": found["force_slow_std"],
        "line": found["pen_line_rms"],
    }


def flown(share: float, count: int) -> list[dict[str, Any]]:
    """The scores of every draw, with the arm taking this share of the surface's motion."""
    robot = load_robot(load_experiment("paper").robot)
    controller = load_controller("following", robot, {"shape.arm_share": share})
    ready = [prepare(load_experiment("paper", drawn), robot, controller) for drawn in draws("paper", count)]
    found = []
    for begin in range(0, count, CHUNK):
        some = ready[begin : begin + CHUNK]
        found += [
            scores(scored_run(takeoff, flight))
            for takeoff, flight in zip(some, fly_native(some), strict=True)
        ]
    return found


def at(rows: list[dict[str, Any]], name: str, part: float) -> float:
    """A percentile of a score over the flights that were not lost."""
    return float(np.percentile([row[name] for row in rows if not row["lost"]], part))


def table(numbers: dict[str, list[dict[str, Any]]]) -> str:
    """A line for every setting."""
    titles = [title for title, _, _ in SCORES.values()]
    lines = ["| `arm_share` | lost | " + " | ".join(titles) + " |", "|---" * (2 + len(titles)) + "|"]
    for share in SHARES:
        rows = numbers[f"{share:g}"]
        cells = [
            f"{scale * at(rows, name, 50.0):.{digits}f} / {scale * at(rows, name, 90.0):.{digits}f}"
            for name, (_, scale, digits) in SCORES.items()
        ]
        lost = sum(bool(row["lost"]) for row in rows)
        lines.append(f"| {share:g} | {lost} of {len(rows)} | {' | '.join(cells)} |")
    return "\n".join(lines)


@styled
def draw(numbers: dict[str, list[dict[str, Any]]]) -> None:
    """Force over motion, median and worst decile."""
    figure = Figure(figsize=(7.16, 2.9), layout="constrained")
    axes = figure.subplots(1, 2, sharex=True)
    rows = [numbers[f"{share:g}"] for share in SHARES]
    x = [1e3 * at(row, "speed", 50.0) for row in rows]
    for ax, part, title in zip(axes, (50.0, 90.0), ("median", "worst decile"), strict=True):
        y = [at(row, "force_std", part) for row in rows]
        ax.plot(x, y, "o-", ms=4)
        for share, where in zip(SHARES, zip(x, y, strict=True), strict=True):
            if share in (0.0, 1.0):
                ax.annotate(f"{share:g}", where, textcoords="offset points", xytext=(4, 4))
        ax.set(xlabel="body along the contact axis, rms (mm/s)", ylabel="force std (N)", title=title)
        ax.set_ylim(0.0, 1.12 * ax.get_ylim()[1])
    figure.savefig(FIGURE, dpi=110, metadata={"Software": None})


def main() -> None:
    """Fly what is missing, keep it, write table and figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--draws", type=int, default=24)
    parser.add_argument("--tables", action="store_true", help="fly nothing: what docs/calm.json holds")
    options = parser.parse_args()
    numbers = json.loads(NUMBERS.read_text(encoding="utf-8")) if NUMBERS.exists() else {}
    for share in () if options.tables else SHARES:
        if (name := f"{share:g}") not in numbers:
            numbers[name] = [short(row) for row in flown(share, options.draws)]
            keep(numbers)
            print(name, flush=True)
    draw(numbers)
    fill(PAGE, "calm", table(numbers))


def keep(numbers: dict[str, list[dict[str, Any]]]) -> None:
    """A line a setting."""
    lines = (f"{json.dumps(key)}: {json.dumps(rows)}" for key, rows in numbers.items())
    NUMBERS.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


def short(row: dict[str, Any]) -> dict[str, Any]:
    """The scores that are kept, with four digits a number."""
    return {
        key: float(f"{value:.4g}") if isinstance(value, float) else value
        for key, value in row.items()
        if key in ("lost", *SCORES)
    }


if __name__ == "__main__":
    main()
