"""Transformations between any two of 50 random feasible postures, vectoring angles planned in flight.

    python benchmarks/transformations.py [--robots dragon ...] [--postures 50] [--tours 4]

Gains and speed were chosen on the draws of lower seeds; the table is of others (`SEEDS`). Postures are drawn
evenly within the joint limits. One counts as feasible where its links keep `CLEARANCE`, the best vectoring
angles leave `LEAST` N m about every axis, and hover is level where the robot has vectoring joints. The
complete graph of an even number 2 n of postures falls into n open tours through all of them (Walecki, 1883),
so all tours have every pair once; each tour is flown in pieces. Where the straight way leaves too little, the
way of `posture_roadmap` is taken.

The free-flight experiment flies at `SPEED` with a second of hold, the sensors' noise seeded by the piece, by
`pid` and what `FLOWN_WITH` changes in it for a robot. What was planned is kept tour by tour in
out/transformations, so that an interrupted run goes on. Rows are kept in docs/transformations.json and
written into docs/reports/feasibility.md.
"""

from __future__ import annotations

import argparse
import itertools
import json
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from posture_roadmap import Place, Roadmap, keeps_clear, rehearse, straight_way  # beside this file

import skylimb
from skylimb.control.controller import load_controller
from skylimb.control.laws.preset import PRESETS
from skylimb.control.planning.posture_path import PostureConfig, posture_path
from skylimb.control.planning.vectoring_step import RATE, first_vectoring, plan_vectoring
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.experiments.experiment import load_experiment
from skylimb.flight.takeoff import prepare
from skylimb.robots import Robot

SEEDS = {"hydrus_xi_quad": 53, "hydrus_xi_hex": 53, "dragon": 52, "hydrus_quad": 52}
"""Of the postures, by robot; nothing was chosen on these."""

SPEED = 0.12  # rad/s
ROBOTS = ("hydrus_xi_quad", "hydrus_xi_hex", "dragon", "hydrus_quad")
LEAST = 1.0  # N m, of a drawn posture
ON_THE_WAY = 0.6  # N m
MILESTONES = 20  # postures besides, which a way may lead through
CLEARANCE = 0.15  # m
PIECE = {"dragon": 6}  # transformations a flight; eight by others. Its ways are long, and 600 s are the most
TOGETHER = 4  # flights at once
PAGE = Path(__file__).parents[1] / "docs" / "reports" / "feasibility.md"
PLANS = PAGE.parents[2] / "out" / "transformations"
KEPT = PAGE.parents[1] / "transformations.json"
LAW: dict[str, Any] = {
    "allocation.leak.compensate": True,
    "allocation.hold_lift": True,
    "translation.integral": [0.5, 0.5, 1.55],
}
FLOWN_WITH: dict[str, tuple[str, dict[str, Any]]] = {
    "hydrus_xi_quad": ("planned", {**LAW, "attitude.normalized_stiffness": [28.0, 28.0, 3.0]}),
    "hydrus_quad": ("planned", LAW),
    "hydrus_xi_hex": (
        "pointed",
        {
            "translation.integral": [1.0, 1.0, 1.55],
            "attitude.virtual_inertia_ratio": [1.0, 1.0, 1.0],
            "attitude.normalized_stiffness": [60.0, 60.0, 1.0],
            "allocation.pointing.damping": 0.0005,
        },
    ),
    "dragon": (
        "pointed",
        {
            "translation.integral": [1.0, 1.0, 1.55],
            "attitude.virtual_inertia_ratio": [1.0, 1.0, 1.0],
            "attitude.normalized_stiffness": [4.0, 4.0, 3.0],
        },
    ),
}
"""Allocation law and gains that differ from those of `pid`, by robot."""
HEAD = (
    "| robot | postures | tours | feasible, no way found | pairs flown | of them by a detour | no way "
    "| lost, of flights | m off: median, "
    "most of a flight | step, rad | least margin, N m | ms of processor a plan: median, 99 %, most |",
    "|---|---|---|---|---|---|---|---|---|---|---|---|",
)
BEGIN, END = "<!-- transformations: written by benchmarks/transformations.py -->", "<!-- end -->"


@dataclass
class Flown:
    """What the flights of a robot showed."""

    postures: int = 0
    drawn: int = 0
    islands: int = 0
    pairs: int = 0
    detours: int = 0
    no_way: int = 0
    lost: int = 0
    away: list[float] = field(default_factory=list)  # m, greatest of a flight
    step: float = 0.0  # rad, greatest change of a commanded vectoring angle in a twentieth of a second
    margin: float = np.inf  # N m
    flights: int = 0
    tours: int = 0
    times: list[float] = field(default_factory=list)  # ms of processor time, of a plan from Python


def drawn(robot: Robot, count: int) -> tuple[Roadmap, list[int], Flown]:
    """A map of feasible postures, and which of them a way leads to from the nominal one."""
    rng, (low, high), flown = np.random.default_rng(SEEDS[robot.name]), robot.joint_limits(), Flown()
    postures: list[np.ndarray] = []
    while True:
        while len(postures) < count + MILESTONES + flown.islands:
            q = rng.uniform(low, high)
            flown.drawn += 1
            if keeps_clear(robot, q[None], CLEARANCE) and hovers(robot, q):
                postures.append(q)
        roadmap = Roadmap(robot, np.array(postures), ON_THE_WAY, CLEARANCE)
        among = range(1, len(postures) - MILESTONES + 1)
        reached = [k for k in among if roadmap.way(roadmap.start, k)]
        flown.islands = len(among) - len(reached)
        if len(reached) >= count or flown.islands > count:
            return roadmap, reached[:count], flown


def hovers(robot: Robot, q: np.ndarray) -> bool:
    """Whether a posture counts as feasible."""
    try:
        best = first_vectoring(robot, q)
    except skylimb.SkylimbError:
        return False
    return best.margin > LEAST and (robot.n_vectoring == 0 or best.feasible(LEAST))


def tours(n: int) -> Iterator[list[int]]:
    """Open tours of 0 .. n - 1 for an even n that have every pair once between them."""
    zigzag = [(k + 1) // 2 * (1 if k % 2 else -1) for k in range(n)]
    for first in range(n // 2):
        yield [(first + step) % n for step in zigzag]


def pieces(roadmap: Roadmap, stops: list[int], tally: dict[str, int]) -> Iterator[PostureConfig]:
    """What each flight of a tour goes through; it begins in the nominal posture.

    A transformation is taken in where a rehearsal of the flight so far, at its own times, leaves enough.
    """
    size = PIECE.get(roadmap.robot.name, 8)
    for k in range(0, len(stops) - 1, size):
        place, config = roadmap.start, PostureConfig(speed=SPEED, hold=1.0, margin=ON_THE_WAY)
        for transformation, goal in enumerate(stops[k : k + size + 1]):
            way = roadmap.way(place, goal)
            longer = config if way is None else through(config, roadmap, way)
            if way is None or not rehearsed(roadmap.robot, longer):
                tally["no_way"] += transformation > 0
                continue
            tally["pairs"] += transformation > 0
            tally["detours"] += transformation > 0 and len(way) > 2
            place, config = way[-1], longer
        yield config


def plans(robot: Robot, postures: int, count: int) -> list[dict[str, Any]]:
    """Each tour's flights and what was counted, as kept, else planned and kept."""
    folder = PLANS / f"{robot.name}-{SEEDS[robot.name]}-{postures}"
    folder.mkdir(parents=True, exist_ok=True)
    files = [folder / f"{tour}.json" for tour in range(count)]
    if any(not file.exists() for file in files):
        roadmap, reached, flown = drawn(robot, postures)
        print(robot.name, len(reached), "postures of", flown.drawn, "draws", flush=True)
        times = plan_times(robot, roadmap, reached)
        for file, tour in zip(files, tours(len(reached)), strict=False):
            if not file.exists():
                tally = {"pairs": 0, "detours": 0, "no_way": 0, "islands": flown.islands}
                ways = [way.waypoints for way in pieces(roadmap, [reached[k] for k in tour], tally)]
                whole = json.dumps({**tally, "ways": ways, "times": times})
                file.with_suffix(".part").write_text(whole, encoding="utf-8")
                file.with_suffix(".part").replace(file)
                print(robot.name, file.stem, tally, flush=True)
    return [json.loads(file.read_text(encoding="utf-8")) for file in files if file.exists()]


def through(config: PostureConfig, roadmap: Roadmap, way: list[Place]) -> PostureConfig:
    """The same with the postures of a way at its end."""
    more = tuple(tuple(roadmap.postures[stop.posture].tolist()) for stop in way[1:])
    return replace(config, waypoints=config.waypoints + more)


def rehearsed(robot: Robot, config: PostureConfig) -> bool:
    """Whether a flight through the postures leaves enough all along, by the margin of its plans."""
    path = posture_path(config, robot, robot.nominal_posture())
    q = path.sample(np.arange(0.0, path.duration + 1.0 / RATE, 1.0 / RATE))
    flown = rehearse(robot, q, first_vectoring(robot).angles)
    return flown.leaves(config.margin)


def fly(robot: Robot, controller: Any, ways: list[list[list[float]]], seed: int, flown: Flown) -> None:
    """Some flights at once, into the tally."""
    takeoffs = []
    for k, way in enumerate(ways):
        posture = {"waypoints": way, "speed": SPEED, "hold": 1.0}
        changes = {"robot": robot.name, "seed": seed + k, "posture": posture, "phases.tare": 1.0}
        takeoffs.append(prepare(load_experiment("free_flight", changes), robot, controller))
    for takeoff, flight in zip(takeoffs, fly_native(takeoffs), strict=True):
        flown.flights += 1
        flown.lost += bool(flight.cause)
        off = flight.signal("cog_position_estimate") - takeoff.mission.reference.position[: flight.ticks]
        flown.away.append(float(np.linalg.norm(off, axis=1).max()))
        commanded = flight.signal("vectoring_angles_command")
        if "pointing" in str(controller.tables()):
            commanded = commanded - flight.signal("vectoring_move")
        planned = commanded[:: round(200.0 / RATE)]
        flown.step = max(flown.step, float(np.abs(np.diff(planned, axis=0)).max(initial=0.0)))
        flown.margin = min(flown.margin, float(flight.signal("vectoring_margin").min()))


def plan_times(robot: Robot, roadmap: Roadmap, reached: list[int]) -> list[float]:
    """Milliseconds of each plan along the ways from the nominal posture."""
    times = []
    for goal in reached[:20]:
        way: list[Place] = roadmap.way(roadmap.start, goal) or []
        for one, other in itertools.pairwise(way):
            psi = roadmap.vectoring_angles(one)
            for q in straight_way(roadmap.postures[one.posture], roadmap.postures[other.posture]):
                begin = time.thread_time()
                psi = plan_vectoring(robot, q, psi).angles
                times.append(1e3 * (time.thread_time() - begin))
    return times


def row(robot: Robot, flown: Flown) -> str:
    """A line of the table."""
    away, times = np.array(flown.away), np.array(flown.times)
    return (
        f"| `{robot.name}` | {flown.postures} | {flown.tours} | {flown.islands} | {flown.pairs} "
        f"| {flown.detours} | {flown.no_way} "
        f"| {flown.lost} of {flown.flights} | {np.median(away):.3f}, {away.max():.3f} "
        f"| {flown.step:.3f} | {flown.margin:.2f} "
        f"| {np.median(times):.2f}, {np.quantile(times, 0.99):.2f}, {times.max():.2f} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--robots", nargs="+", default=ROBOTS)
    parser.add_argument("--postures", type=int, default=50)
    parser.add_argument("--tours", type=int, default=4, help="of 25, how many to fly")
    given = parser.parse_args()
    rows = json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}
    with tempfile.TemporaryDirectory() as folder:
        for name in given.robots:
            robot = skylimb.load_robot(name)
            controller = controller_of(robot, Path(folder))
            flown = Flown(given.postures)
            for tour, kept in enumerate(plans(robot, given.postures, given.tours)):
                flown.islands, flown.tours = kept["islands"], tour + 1
                flown.pairs, flown.detours = flown.pairs + kept["pairs"], flown.detours + kept["detours"]
                flown.no_way, flown.times = flown.no_way + kept["no_way"], [*flown.times, *kept["times"]]
                for k in range(0, len(kept["ways"]), TOGETHER):
                    fly(robot, controller, kept["ways"][k : k + TOGETHER], 100 * tour + k, flown)
                rows[name] = row(robot, flown)
                KEPT.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
            print(rows[name], flush=True)
    write([*HEAD, *(rows[name] for name in ROBOTS if name in rows)])


def controller_of(robot: Robot, folder: Path) -> Any:
    """`pid` with the allocation and the gains that a robot is flown with."""
    law, gains = FLOWN_WITH[robot.name]
    preset = folder / f"pid_{law}.toml"
    text = (PRESETS / "pid.toml").read_text(encoding="utf-8")
    preset.write_text(text.replace('law = "pseudoinverse"', f'law = "{law}"'), encoding="utf-8")
    return load_controller(str(preset), robot, gains)


def write(lines: list[str]) -> None:
    """The table, between its marks in the page."""
    page = PAGE.read_text(encoding="utf-8")
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    PAGE.write_text(f"{before}{BEGIN}\n\n" + "\n".join(lines) + f"\n\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
