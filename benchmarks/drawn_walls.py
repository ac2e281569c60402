"""How robots of the table of robots draw on a wall that is not as believed: losses, line, touch over draws.

    python benchmarks/drawn_walls.py                    the tables of docs/reports/robots.md, some minutes
    python benchmarks/drawn_walls.py --only bicopter --set allocation.rotor_lag.reaction=false

Each draw: friction 0.1 to 0.6, thrust 2 % and mass 1 % off, the centre of gravity up to 10 mm along each
axis, latency 10 to 30 ms (20 are assumed). The same draws for every robot and controller.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import warnings
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "helpers"))

import numpy as np
from robots_made import ARMED, KINDS

import skylimb
from armed_robots import multirotor_with_arm
from skylimb.analysis.recording.run import UNFINISHED
from skylimb.base.config import parse_assignment

BOARD, SEED = "board_tilted_hexarotor", 7
SHORT = {"stick": 0.3}
FLOWN: dict[str, tuple[str, dict[str, Any], float]] = {
    "tricopter, each arm turns": ("tricopter, each arm turns", {}, 1.0),
    "tricopter, its tail turns": ("tricopter, its tail turns", {}, 0.7),
    "tricopter, its tail turns, short stick": ("tricopter, its tail turns", {"stick": 0.2}, 1.0),
    "bicopter, rotors above its stick": ("bicopter, rotors above its stick", {}, 0.5),
    "bicopter, rotors above its stick, short": (
        "bicopter, rotors above its stick",
        {"layers": (0.1,), **SHORT},
        0.5,
    ),
    "Tilt-Hex, canted by 20 degrees": ("Tilt-Hex, canted by 20 degrees", {}, 1.0),
    "tilted octorotor, reversible": ("tilted octorotor, reversible", {}, 1.0),
    "tilted hexarotor, stick": ("tilted hexarotor, stick", {}, 1.0),
    "tilted hexarotor, 2 joints": ("tilted hexarotor, 2 joints", {}, 1.0),
    "tilted octorotor, 6 joints": ("tilted octorotor, 6 joints", {}, 1.0),
}
"""Name, the robot of `robots_made`, what is changed in it, and the force, N."""


class Flight(NamedTuple):
    """How one ended: lost attitude or height, or out of time; done; line, m; share of time in touch."""

    crashed: bool
    late: bool
    done: bool
    line: float | None
    touch: float | None


def flown(job: tuple[str, str, float, int, dict[str, Any]]) -> Flight:
    """One draw."""
    robot, controller, force, draw, changes = job
    warnings.simplefilter("ignore")
    rng = np.random.default_rng([SEED, draw])
    drawn = {
        "surface.friction": float(rng.uniform(0.1, 0.6)),
        "plant.thrust_scale": float(rng.uniform(0.98, 1.02)),
        "plant.mass_scale": float(rng.uniform(0.99, 1.01)),
        "plant.cog_offset": rng.uniform(-0.01, 0.01, 3).tolist(),
        "sensors.latency": float(rng.uniform(0.01, 0.03)),
    }
    given = {"robot": robot, "controller.translation.force": force, "approach.doubtful": "fly"}
    run = skylimb.run(BOARD, controller, set={**given, **drawn, **changes}, seed=draw)
    found = run.metrics
    return Flight(
        run.lost,
        run.status == UNFINISHED,
        bool(found["done"]),
        found["pen_line_rms"],
        found["contact_fraction"],
    )


def row(name: str, controller: str, flights: list[Flight]) -> str:
    """A line of the table."""
    count = len(flights)
    crashed, late, done = (sum(getattr(one, key) for one in flights) for key in ("crashed", "late", "done"))
    lines = [1e3 * one.line for one in flights if one.line is not None]
    touch = [one.touch for one in flights if one.touch is not None]
    length = f"{np.median(lines):.1f}, {np.max(lines):.1f}" if lines else ""
    touched = f"{np.median(touch):.2f}" if touch else ""
    return f"| {name} | {controller} | {crashed} of {count} | {late} | {done} | {length} | {touched} |"


def main() -> None:
    """Fly and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--draws", type=int, default=12)
    parser.add_argument("--only", nargs="*", default=[])
    parser.add_argument("--controllers", nargs="*", default=["following", "drawing"])
    parser.add_argument("--set", nargs="*", default=[], help="gains, KEY=VALUE")
    given = parser.parse_args()
    changes = {f"controller.{key}": value for key, value in map(parse_assignment, given.set)}
    warnings.simplefilter("ignore")
    print("| robot | controller | crashed | out of time | done | line, mm: median, worst | touch, median |")
    print("|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as place, ProcessPoolExecutor(2) as pool:
        for k, (name, (made, other, force)) in enumerate(FLOWN.items()):
            if given.only and not any(word in name for word in given.only):
                continue
            of = {**KINDS, **ARMED}[made]
            robot = str(Path(place) / str(k))
            skylimb.import_robot(multirotor_with_arm(Path(f"{robot}.urdf"), **{**of.given, **other}), robot)
            for controller in given.controllers:
                jobs = [(robot, controller, force, draw, changes) for draw in range(given.draws)]
                print(row(name, controller, list(pool.map(flown, jobs))), flush=True)


if __name__ == "__main__":
    main()
