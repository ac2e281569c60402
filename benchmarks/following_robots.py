"""What the preset `following` reaches on other robots than the one it was made for, on the paper's board.

    python benchmarks/following_robots.py [--draws 100] [--robots dragon ...]

The draws are those of benchmarks/following.py (its seed and its prior; rotors beyond the fourth are drawn
besides), the same ones for every robot. The preset is the shipped one, with what it says of each robot.
Errors are medians over the flights of each one's score; beside them, in brackets, error over reach against
that of the quad. Force has no length in it: its bracket is the plain ratio. Numbers are kept in
docs/following_robots.json after every few flights, with a digest of the controller, so that an interrupted
run goes on and one with other gains begins anew; the table is written into docs/reports/robots.md.
"""

from __future__ import annotations

import argparse
import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
from following import SEED, draws, scored

from skylimb.control.controller import load_controller, resolved_tables
from skylimb.control.planning.posture import posture_family
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.experiments.experiment import load_experiment
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import prepare
from skylimb.robots import Robot
from skylimb.robots.loader import load_robot

QUAD = "hydrus_xi_quad"
ROBOTS = (QUAD, "tilted_hexarotor", "tiltable_hexarotor", "dragon", "hydrus_quad")
TOGETHER = 5
PAGE = Path(__file__).parents[1] / "docs" / "reports" / "robots.md"
KEPT = PAGE.parents[1] / "following_robots.json"
BEGIN, END = "<!-- following: written by benchmarks/following_robots.py -->", "<!-- end of following -->"
SHOWN = (
    ("y, mm", "error_u_median", 1e3),
    ("z, mm", "error_v_median", 1e3),
    ("pen line, mm", "pen_line_rms", 1e3),
    ("force std of 0.2 s, N", "force_slow_std", 1.0),
    ("force std, N", "contact_force_normal_std", 1.0),
)
"""Column, score and scale. Lengths are scaled by reach."""


def drawn(robot: Robot, count: int) -> list[dict[str, Any]]:
    """The draws of benchmarks/following.py for a robot of any number of rotors."""
    more = np.random.default_rng(SEED + 1)
    rotors, found = len(robot.description.rotors), []
    for changes in draws("paper", count):
        scale = [*changes["plant.rotor_scale"], *more.uniform(0.98, 1.02, max(rotors - 4, 0)).tolist()]
        found.append({**changes, "plant.rotor_scale": scale, "robot": robot.name})
    return found


def fly(name: str, count: int, kept: dict[str, Any]) -> None:
    """The flights of a robot that are not kept yet."""
    robot = load_robot(name)
    controller = load_controller("following", robot)
    tables = json.dumps([resolved_tables(controller), SHOWN], sort_keys=True)
    digest = hashlib.sha256(tables.encode()).hexdigest()[:12]
    if kept.get(name, {}).get("controller") != digest:
        reach = float(posture_family(robot).reach_nominal)
        kept[name] = {"reach": reach, "controller": digest, "scores": []}
    scores = kept[name]
    changes = drawn(robot, count)
    for begin in range(len(scores["scores"]), count, TOGETHER):
        ready = [
            prepare(load_experiment("paper", given), robot, controller)
            for given in changes[begin : min(begin + TOGETHER, count)]
        ]
        for takeoff, flight in zip(ready, fly_native(ready), strict=True):
            score = scored(scored_run(takeoff, flight))
            scores["scores"].append({key: score.get(key) for key in ("cause", *(key for _, key, _ in SHOWN))})
        KEPT.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")


def row(name: str, kept: dict[str, Any]) -> str:
    """A line of the table."""
    own, quad = kept[name], kept[QUAD]
    flown = own["scores"]
    cells = [
        f"`{name}`",
        f"{own['reach']:.2f}",
        f"{sum(bool(score['cause']) for score in flown)} of {len(flown)}",
    ]
    for _, key, scale in SHOWN:
        value, beside = median(flown, key), median(quad["scores"], key)
        longer = own["reach"] / quad["reach"] if scale != 1.0 else 1.0
        cells.append(f"{scale * value:.2f} ({value / beside / longer:.2f})")
    return "| " + " | ".join(cells) + " |"


def median(scores: list[dict[str, Any]], key: str) -> float:
    """Median of a score over the flights that were not lost; not a number without any."""
    known = [score[key] for score in scores if not score["cause"] and score[key] is not None]
    return float(np.median(known)) if known else float("nan")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument("--robots", nargs="+", default=ROBOTS)
    given = parser.parse_args()
    kept = json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}
    for name in (QUAD, *(robot for robot in given.robots if robot != QUAD)):
        fly(name, given.draws, kept)
        print(row(name, kept), flush=True)
    head = ["robot", "reach, m", "lost", *(title for title, _, _ in SHOWN)]
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    lines += [row(name, kept) for name in ROBOTS if name in kept]
    page = PAGE.read_text(encoding="utf-8")
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    PAGE.write_text(f"{before}{BEGIN}\n\n" + "\n".join(lines) + f"\n\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
