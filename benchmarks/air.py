"""What drag of the rotors and a wall beside them do to contact: the same flights with and without them.

    python benchmarks/air.py [--draws 20] [--only TEXT]

The draws of benchmarks/following.py, on the paper's board: six controllers and three kinds of air. Half of
those boards are too hard for the paper's four controllers, so these get the paper's slope and friction. One
air is next to nothing, and says how far apart flights are that differ in their last bits. docs/air.json keeps
a line a flight; one that it holds is not flown again. The table of docs/reports/second_engine.md is written
anew.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

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
PAGE, NUMBERS = DOCS / "reports" / "second_engine.md", DOCS / "air.json"
LEFT_OUT = {
    **dict.fromkeys(("pid", "impedance", "admittance", "hybrid"), ("surface.slope", "surface.friction")),
    "following": (),
    "drawing": ("trajectory.direction",),
}
"""The controllers, and what of the draws each keeps from the experiment."""
WALL = {"plant.wall_loss": WALL_SHARE, "plant.wall_pull": WALL_SHARE}
NOTHING = "next to nothing"
AIRS: Mapping[str, Mapping[str, float]] = {
    NOTHING: {"plant.rotor_drag": 1e-9},
    "drag": {"plant.rotor_drag": ROTOR_DRAG},
    "wall": WALL,
    "both": {"plant.rotor_drag": ROTOR_DRAG, **WALL},
}
COMPARED = {"cog_position": "cog", "tip_position": "pen", "contact_force": "force"}
SCORES = {"line": "pen_line_rms", "std": "contact_force_normal_std"}
CHUNK = 5
AVERAGED = 20
"""Ticks over which forces are averaged: a tick's own is the chatter of a sliding pen."""


class Flown(NamedTuple):
    """What is kept of a flight: why it was lost, its clock, signals, (axes, ticks) each, and scores."""

    lost: str
    clock: np.ndarray
    signals: dict[str, np.ndarray]
    scores: dict[str, float]


def flown(run: Run) -> Flown:
    """A run without all that is not compared.

    A path that waits for its pen has a clock of its own: places are compared at the same place of it.
    """
    clock = run.log["mission_time" if "mission_time" in run.log else "time"].values
    signals = {name: run.log[name].values.T.copy() for name in COMPARED}
    scores = {} if run.failed else {name: float(run.metrics[key]) for name, key in SCORES.items()}
    return Flown(run.cause * run.failed, clock, signals, scores)


def flights(preset: str, air: Mapping[str, float], drawn: Sequence[Mapping[str, Any]]) -> list[Flown]:
    """A flight of each draw."""
    robot = load_robot(load_experiment("paper").robot)
    controller = load_controller(preset, robot)
    own: Mapping[str, Any] = {**PEN, **DRAWINGS["skylimb.svg"]} if preset == "drawing" else {}
    left_out = LEFT_OUT[preset]
    found: list[Flown] = []
    for begin in range(0, len(drawn), CHUNK):
        ready = [
            prepare(
                load_experiment(
                    "paper", {k: v for k, v in {**own, **one, **air}.items() if k not in left_out}
                ),
                robot,
                controller,
            )
            for one in drawn[begin : begin + CHUNK]
        ]
        found += [flown(scored_run(*pair)) for pair in zip(ready, fly_native(ready), strict=True)]
    return found


def apart(still: Flown, moved: Flown) -> dict[str, Any]:
    """What the air changed in one draw: rms of differences in mm and mN, and the scores of both."""
    found: dict[str, Any] = {"lost still": still.lost, "lost moved": moved.lost}
    if still.lost or moved.lost:
        return found
    clock = still.clock[: min(len(still.clock), len(moved.clock))]
    window = np.ones(AVERAGED) / AVERAGED
    for signal, name in COMPARED.items():
        there, here = (at(clock, flight.clock, flight.signals[signal]) for flight in (moved, still))
        off = there - here
        if name == "force":
            off = np.array([np.convolve(row, window, "valid") for row in off])
        found[name] = 1e3 * rms(off)
    for which, flight in (("still", still), ("moved", moved)):
        found |= {f"{name} {which}": value for name, value in flight.scores.items()}
    return found


def at(clock: np.ndarray, own: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Rows (axes, ticks) of a flight with a clock of its own, at the times of another."""
    rising, first = np.unique(own, return_index=True)
    return np.array([np.interp(clock, rising, row[first]) for row in rows])


def rms(rows: np.ndarray) -> float:
    """Of vectors, (axes, ticks)."""
    return float(np.sqrt(np.mean(np.sum(rows**2, axis=0))))


def cells(only: str) -> Iterator[tuple[str, str]]:
    """Controller and air of each row."""
    for preset in LEFT_OUT:
        for air in AIRS:
            if only in f"{preset} {air}":
                yield preset, air


def table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Median and worst of the draws, a controller and an air a line."""
    shown_airs = [air for air in AIRS if air != NOTHING]
    lines = [
        "| controller | air | lost | CoG mm | pen mm | force mN | pen to line mm | force std N |",
        "|---" * 8 + "|",
    ]
    for preset in LEFT_OUT:
        for air in shown_airs:
            own = [row for row in rows if (row["preset"], row["air"]) == (preset, air)]
            home = [row for row in own if "cog" in row]
            if not home:
                continue
            shown = [
                f"{short(np.median([row[key] for row in home]))} / {short(max(row[key] for row in home))}"
                for key in ("cog", "pen", "force")
            ]
            for name, scale in (("line", 1e3), ("std", 1.0)):
                both = [
                    scale * float(np.median([row[f"{name} {which}"] for row in home]))
                    for which in ("still", "moved")
                ]
                shown.append(" → ".join(map(short, both)))
            lost = [sum(bool(row[f"lost {which}"]) for row in own) for which in ("still", "moved")]
            lines.append(
                f"| `{preset}` | {air} | {lost[0]} → {lost[1]} of {len(own)} | {' | '.join(shown)} |"
            )
    return "\n".join(lines)


def short(value: Any) -> str:
    """Three digits, none of them behind a point where it is large."""
    return f"{value:.0f}" if value >= 100.0 else f"{value:.3g}"


def main() -> None:
    """Fly what is not kept, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--only", default="", help="fly the rows with this in their name")
    given = parser.parse_args()
    drawn = list(draws("paper", given.draws))
    rows: list[dict[str, Any]] = json.loads(NUMBERS.read_text()) if NUMBERS.exists() else []
    still: dict[str, list[Flown]] = {}
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
        print(f"{preset}, {air}", flush=True)
    fill(PAGE, "air", table(rows))


if __name__ == "__main__":
    main()
