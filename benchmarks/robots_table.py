"""The page of robots from their files: check, hover, touch and a line on a board, without a word of mapping.

    python benchmarks/robots_table.py FILE.urdf ... > table.md

Robots that ship and multirotors with arms, made as their makers write them (`tests/helpers/armed_robots.py`),
are flown as well. Times are of processor, s.
"""

from __future__ import annotations

import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "helpers"))

import skylimb
from armed_robots import SIX, TWO, multirotor_with_arm
from skylimb.base.errors import SkylimbError

BOARD = "board_tilted_hexarotor"
FORCES = (1.0, 0.7, 0.5)
"""Forces that are tried, N: with more a robot may be refused for a yaw that is too weak."""

ARM = {"joints": TWO}
MADE: dict[str, dict] = {
    "quadrotor, 2 joints": ARM,
    "quadrotor, 2 joints, tool's z forward": {**ARM, "tool": "0 1.5708 0"},
    "quadrotor, 1 joint": {"joints": TWO[:1], "stick": 0.2},
    "quadrotor, 3 joints": {"joints": (*TWO, ("wrist_pitch", "0 1 0", 0.08))},
    "quadrotor, plain names": {"joints": (("m1", "0 1 0", 0.25), ("m2", "0 1 0", 0.25))},
    "quadrotor, stick": {"joints": (), "stick": 0.45},
    "hexarotor, 2 joints": {**ARM, "rotors": 6, "place": 0.32, "mass": 2.2},
    "hexarotor, 6 joints": {"joints": SIX, "rotors": 6, "place": 0.32, "mass": 2.2},
    "hexarotor, stick": {"joints": (), "stick": 0.5, "rotors": 6, "place": 0.32, "mass": 2.2},
    "octorotor, 6 joints": {"joints": SIX, "rotors": 8, "place": 0.36, "mass": 3.0, "radius": 0.1},
    "tilted hexarotor, stick": {"joints": (), "stick": 0.4, "rotors": 6, "place": 0.32, "cant": 0.3},
    "tilted hexarotor, 2 joints": {**ARM, "rotors": 6, "place": 0.32, "mass": 2.2, "cant": 0.3},
    "tilted octorotor, 6 joints": {
        "joints": SIX, "rotors": 8, "place": 0.36, "mass": 3.0, "radius": 0.1, "cant": 0.3,
    },
}  # fmt: skip
"""What `multirotor_with_arm` makes of each."""


def timed(work: Callable[[], object]) -> tuple[Any, float]:
    """What a call gives, a refusal as its words, and its time."""
    begin = time.process_time()
    found: Any
    try:
        found = work()
    except SkylimbError as error:
        found = str(error).split(";")[0]
    return found, time.process_time() - begin


def row(name: str, path: Path, folder: Path, *, ships: bool = False) -> str:
    """A line of the table."""
    robot = str(path) if ships else str(folder / "robot")
    work = (lambda: skylimb.check_robot_file(path)) if ships else lambda: skylimb.import_robot(path, robot)
    report, checking = timed(work)
    if isinstance(report, str):
        return f"| {name} | refused: {report[:80]} | | | | | |"
    hover, touch = ("yes" if yes else "no" for yes in (report.can_hover, report.can_touch))
    free = {"robot": robot, "posture.waypoints": [], "stop_at": 5.0}
    hovered, _ = timed(lambda: skylimb.run("free_flight", "following", set=free))
    flown = hovered if isinstance(hovered, str) else hovered.status == "STOPPED"
    line, taken = "", 0.0
    for force in FORCES if report.can_touch else ():
        keys = {"robot": robot, "controller.translation.force": force}
        run, taken = timed(lambda keys=keys: skylimb.run(BOARD, "following", set=keys))
        if not isinstance(run, str):
            score = run.metrics["pen_line_rms"]
            line = (
                "lost"
                if score is None
                else f"{1e3 * score:.1f} mm, touch {run.metrics['contact_fraction']:.2f}"
            )
            line += f", {force:g} N, {'done' if run.metrics['done'] else 'not done'}"
            break
        line = f"refused: {run[:70]}"
    said = "yes" if flown is True else "no" if flown is False else f"refused: {flown[:60]}"
    return f"| {name} | {hover} | {said} | {touch} | {line} | {checking:.1f} | {taken:.1f} |"


def main() -> None:
    """Print the table."""
    warnings.simplefilter("ignore")
    print("| robot | check: hover | flown: hover | check: touch | line on a board | check, s | flight, s |")
    print("|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as place:
        rows = [(name, Path(name), True) for name in skylimb.list_robots()]
        rows += [(Path(word).stem, Path(word), False) for word in sys.argv[1:]]
        rows += [
            (name, multirotor_with_arm(Path(place) / f"made{k}.urdf", **given), False)
            for k, (name, given) in enumerate(MADE.items())
        ]
        for k, (name, path, ships) in enumerate(rows):
            folder = Path(place) / str(k)
            folder.mkdir()
            print(row(name, path, folder, ships=ships), flush=True)


if __name__ == "__main__":
    main()
