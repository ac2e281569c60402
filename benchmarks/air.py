"""What drag of the rotors and a wall beside them do to contact: the same flights with and without them.

    python benchmarks/air.py [--draws 20] [--only TEXT]

The draws of benchmarks/following.py, on the paper's board: six controllers, three kinds of air, and one that
is next to nothing, which says how far apart flights are that differ in their last bits. docs/air.json keeps a
line a flight; one that it holds is not flown again. The table of docs/second_engine.md is written anew.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from drawing import DRAWINGS, PEN  # beside this file, as the next two
from following import draws
from kept import fill, keep

from skylimb.analysis.recording.run import Run
from skylimb.control.controller import load_controller
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.experiments.experiment import load_experiment
from skylimb.flight.physics_sheet import ROTOR_DRAG, WALL_SHARE
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import prepare
from skylimb.robots.loader import load_robot

DOCS = Path(__file__).parents[1] / "docs"
PAGE, NUMBERS = DOCS / "second_engine.md", DOCS / "air.json"
PRESETS = ("pid", "impedance", "admittance", "hybrid", "following", "drawing")
WALL = {"plant.wall_loss": WALL_SHARE, "plant.wall_pull": WALL_SHARE}
AIRS: Mapping[str, Mapping[str, float]] = {
    "next to nothing": {"plant.rotor_drag": 1e-9},
    "drag": {"plant.rotor_drag": ROTOR_DRAG},
    "wall": WALL,
    "both": {"plant.rotor_drag": ROTOR_DRAG, **WALL},
}
AVERAGED = 20
"""Ticks over which forces are averaged: a tick's own is the chatter of a sliding pen."""


def flights(preset: str, air: Mapping[str, float], drawn: Sequence[Mapping[str, Any]]) -> list[Run]:
    """A flight of each draw."""
    robot = load_robot(load_experiment("paper").robot)
    controller = load_controller(preset, robot)
    own: Mapping[str, Any] = {**PEN, **DRAWINGS["skylimb.svg"]} if preset == "drawing" else {}
    left_out = {"trajectory.direction"} if own else set()
    ready = [
        prepare(
            load_experiment("paper", {k: v for k, v in {**own, **one, **air}.items() if k not in left_out}),
            robot,
            controller,
        )
        for one in drawn
    ]
    return [scored_run(*pair) for pair in zip(ready, fly_native(ready), strict=True)]


def apart(still: Run, moved: Run) -> dict[str, Any]:
    """What the air changed in one draw: rms of differences in mm and mN, and the scores of both."""
    lost = next((run.cause for run in (still, moved) if run.failed), "")
    if lost:
        return {"lost": lost}
    count = min(run.log.sizes["time"] for run in (still, moved))
    # A path that waits for its pen has a clock of its own: places are compared at the same place of it.
    clocks = [
        run.log.mission_time.values if "mission_time" in run.log else run.log.time.values
        for run in (still, moved)
    ]

    def at(run: Run, clock: np.ndarray, name: str) -> np.ndarray:
        values = run.log[name].values
        rising, first = np.unique(clock, return_index=True)
        return np.array([np.interp(clocks[0][:count], rising, column[first]) for column in values.T])

    off = {
        name: at(moved, clocks[1], name) - at(still, clocks[0], name)
        for name in ("cog_position", "tip_position", "contact_force")
    }
    window = np.ones(AVERAGED) / AVERAGED
    force = np.array([np.convolve(row, window, "valid") for row in off["contact_force"]])
    return {
        "lost": "",
        "cog": 1e3 * rms(off["cog_position"]),
        "pen": 1e3 * rms(off["tip_position"]),
        "force": 1e3 * rms(force),
        **{
            f"{name} {which}": float(run.metrics[key])
            for name, key in (("line", "pen_line_rms"), ("std", "contact_force_normal_std"))
            for which, run in (("still", still), ("moved", moved))
        },
    }


def rms(rows: np.ndarray) -> float:
    """Of vectors, (axes, ticks)."""
    return float(np.sqrt(np.mean(np.sum(rows**2, axis=0))))


def cells(only: str) -> Iterator[tuple[str, str]]:
    """Controller and air of each row."""
    for preset in PRESETS:
        for air in AIRS:
            if only in f"{preset} {air}":
                yield preset, air


def table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Median and worst of the draws, a controller and an air a line."""
    lines = [
        "| controller | air | lost | CoG mm | pen mm | force mN | pen to line mm | force std N |",
        "|---" * 8 + "|",
    ]
    for preset in PRESETS:
        for air in AIRS:
            own = [row for row in rows if (row["preset"], row["air"]) == (preset, air)]
            home = [row for row in own if not row["lost"]]
            if not home:
                continue
            shown = [
                f"{np.median([row[key] for row in home]):.2g} / {max(row[key] for row in home):.2g}"
                for key in ("cog", "pen", "force")
            ]
            for name, scale in (("line", 1e3), ("std", 1.0)):
                both = [
                    scale * float(np.median([row[f"{name} {which}"] for row in home]))
                    for which in ("still", "moved")
                ]
                shown.append(f"{both[0]:.3g} → {both[1]:.3g}")
            lines.append(
                f"| `{preset}` | {air} | {len(own) - len(home)} of {len(own)} | {' | '.join(shown)} |"
            )
    return "\n".join(lines)


def main() -> None:
    """Fly what is not kept, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--only", default="", help="fly the rows with this in their name")
    given = parser.parse_args()
    drawn = list(draws("paper", given.draws))
    rows: list[dict[str, Any]] = json.loads(NUMBERS.read_text()) if NUMBERS.exists() else []
    still: dict[str, list[Run]] = {}
    for preset, air in cells(given.only):
        if sum((row["preset"], row["air"]) == (preset, air) for row in rows) >= given.draws:
            continue
        if preset not in still:
            still = {preset: flights(preset, {}, drawn)}
        moved = flights(preset, AIRS[air], drawn)
        rows = [row for row in rows if (row["preset"], row["air"]) != (preset, air)]
        rows += [
            {"preset": preset, "air": air, "draw": number, **apart(*pair)}
            for number, pair in enumerate(zip(still[preset], moved, strict=True))
        ]
        keep(NUMBERS, rows)
        print(
            table([row for row in rows if (row["preset"], row["air"]) == (preset, air)]).splitlines()[-1],
            flush=True,
        )
    fill(PAGE, "air", table(rows))


if __name__ == "__main__":
    main()
