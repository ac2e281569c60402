"""Three tasks of published papers: how well the paper's robot and a fully actuated hexarotor do them.

    python benchmarks/tasks.py [--draws 100] [--minutes 60] [--tables]

Draws, as a robot is once it is calibrated, seeds that no gain was chosen on: attitude misaligned by up to
0.1 degrees about each axis, thrust of each rotor +-1 %, mass +-1 %, centre of gravity +-1 mm, inertia of the
rotors 1.4 .. 2.6e-4 kg m^2; latency 10 .. 30 ms (20 assumed); friction 0.1 .. 0.6, stiffness of pen and wall
1 .. 20 N/mm, a wall that leans by up to 6 degrees; noise of every sensor as in all experiments.
docs/tasks.json keeps every flight, a line each; one that it holds is not flown again. The table of
docs/tasks.md is written anew.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from kept import fill, keep  # beside this file

from skylimb.flight.drivers.native import fly_native
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import take_off

DOCS = Path(__file__).parents[1] / "docs"
PAGE, NUMBERS = DOCS / "tasks.md", DOCS / "tasks.json"
SEED = 4711
TASKS = ("calligraphy", "push_and_slide", "writing")
FLOWN = (("hydrus_xi_quad", "drawing", 4), ("tilted_hexarotor", "drawing", 6))
"""Robot, preset, rotors."""
COLUMNS = (
    ("IoU of the area", "area_iou", 1.0, 10, ""),
    ("tip, rms", "pen_line_rms", 1e3, 90, " mm"),
    ("force, rms", "force_error_rms", 1.0, 90, " N"),
    ("in touch", "contact_fraction", 1.0, 10, ""),
)
"""Title, score, scale, which percentile is the worst decile, unit."""


def draws(count: int, rotors: int) -> Iterator[dict[str, Any]]:
    """Changes to an experiment, the same ones whatever it is."""
    rng = np.random.default_rng(SEED)
    for _ in range(count):
        yield {
            "seed": int(rng.integers(1_000_000)),
            "sensors.attitude_misalignment": np.radians(rng.uniform(-0.1, 0.1, 3)).tolist(),
            "plant.mass_scale": rng.uniform(0.99, 1.01),
            "plant.cog_offset": (0.001 * rng.uniform(-1.0, 1.0, 3)).tolist(),
            "plant.rotor_inertia": rng.uniform(1.4e-4, 2.6e-4),
            "sensors.latency": rng.uniform(0.01, 0.03),
            "surface.friction": rng.uniform(0.1, 0.6),
            "surface.stiffness": 1000.0 * 20.0 ** rng.uniform(),
            "surface.slope": float(np.radians(rng.uniform(-6.0, 6.0))),
            "plant.rotor_scale": rng.uniform(0.99, 1.01, 6)[:rotors].tolist(),
        }


def fly(task: str, robot: str, preset: str, drawn: Mapping[str, Any]) -> dict[str, Any]:
    """The scores of one flight."""
    (takeoff,) = take_off(task, (preset,), None, {"robot": robot, **drawn})
    run = scored_run(takeoff, fly_native([takeoff])[0])
    if run.failed:
        return {"lost": run.cause}
    return {"lost": "", **{key: run.metrics[key] for _, key, *_ in COLUMNS}, "done": run.metrics["done"]}


def table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Median and worst decile, a line for each task and robot."""
    head = ("task", "robot, preset", "draws", "lost", *(title for title, *_ in COLUMNS), "done")
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for task in TASKS:
        for robot, preset, _ in FLOWN:
            own = [row for row in rows if (row["task"], row["robot"]) == (task, robot)]
            kept = [row for row in own if not row["lost"]]
            if not kept:
                continue
            cells = [f"`{task}`", f"{robot}, `{preset}`", str(len(own)), str(len(own) - len(kept))]
            for _, key, scale, worst, unit in COLUMNS:
                values = [scale * row[key] for row in kept if row[key] is not None]
                some = np.percentile(values, [50, worst]) if values else None
                cells.append("-" if some is None else f"{some[0]:.3g} / {some[1]:.3g}{unit}")
            lines.append("| " + " | ".join([*cells, str(sum(row["done"] for row in kept))]) + " |")
    return "\n".join(lines)


def main() -> None:
    """Fly what is missing, keep it, write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument("--minutes", type=float, default=60.0, help="begin no more flights after so long")
    parser.add_argument("--tables", action="store_true", help="fly nothing: the table of docs/tasks.json")
    options = parser.parse_args()
    rows = json.loads(NUMBERS.read_text(encoding="utf-8")) if NUMBERS.exists() else []
    known, began = {(row["task"], row["robot"], row["draw"]) for row in rows}, time.monotonic()
    drawn = {robot: list(draws(options.draws, rotors)) for robot, _, rotors in FLOWN}
    for number in range(0 if options.tables else options.draws):
        for task in TASKS:
            for robot, preset, _ in FLOWN:
                late = time.monotonic() - began > 60.0 * options.minutes
                if late or (task, robot, number) in known:
                    continue
                rows.append(
                    {"task": task, "robot": robot, "draw": number}
                    | fly(task, robot, preset, drawn[robot][number])
                )
                keep(NUMBERS, rows)
                print(len(rows), rows[-1], flush=True)
    fill(PAGE, "tasks", table(rows))
    print(table(rows))


if __name__ == "__main__":
    main()
