"""What the preset `following` reaches over random draws, beside the paper's hybrid, and what each part buys.

    python benchmarks/following.py [--draws 200]    (an hour on two cores)

Draws: friction 0.1 .. 0.8, stiffness of the pen 1 .. 20 N/mm (evenly in its logarithm), thrust +-2 % overall
and per rotor, misaligned attitude +-1 degree about each axis, mass +-1 %, centre of gravity +-10 mm along
each axis, latency 10 .. 30 ms (20 assumed), both directions of the circle; on the paper's board 14 and 20
degrees toward both sides. docs/following.json keeps every number, and the tables of
docs/reports/following_results.md are written anew.
`--tables` writes them from the numbers that were kept, `--only TEXT` flies the rows with
that text in their name and keeps all others.

Both presets are held to the same three things: the centre of gravity to the mission's reference, the pen to
its reference line, and the force. What only `following` has stands in columns of its own: the distance of the
centre of gravity from the law's own target, and that of the mean force from the one that was wanted.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from kept import fill  # beside this file

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.registry import measured
from skylimb.control.controller import load_controller
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.experiments.experiment import load_experiment
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import Takeoff, prepare
from skylimb.robots.loader import load_robot

DOCS = Path(__file__).parents[1] / "docs"
PAGE = DOCS / "reports" / "following_results.md"
SEED, CHUNK = 7, 16
Changes = Mapping[str, Any]
NONE: Changes = MappingProxyType({})

EXPERIMENTS = (
    ("paper board, 14 and 20 degrees, both sides", "paper"),
    ("cylinder 1 m, convex", "cylinder_convex"),
    ("cylinder 1 m, concave", "cylinder_concave"),
    ("friction patches", "friction_patches"),
    ("sine, gentle", "sine_gentle"),
    ("sine, steep", "sine_steep"),
    ("ceiling, pen on a mast", "ceiling"),
)
WEDGE: Changes = {
    "surface.friction": 0.78,
    "surface.slope": float(np.radians(-20.0)),
    "trajectory.direction": 1,
}
HARDER: tuple[tuple[str, Changes, Changes], ...] = (
    ("centre of gravity off by 10 mm level, 0 upright", {"level cog": True}, {}),
    ("compass true", {"compass": True}, {}),
    ("compass and centre of gravity true", {"compass": True, "cog": True}, {}),
    ("touched at 50 mm/s", {}, {"contact.approach_speed": 0.05}),
    ("friction 0.78 on 20 degrees that come toward the pen", WEDGE, {}),
    ("the same, pressing on where the pen stays behind", WEDGE, {"contact.least_ease": 1.0}),
    ("latency 50 ms, and known", {"sensors.latency": 0.05}, {"estimation.delay.latency": 0.05}),
    ("latency 50 ms, 20 ms assumed", {"sensors.latency": 0.05}, {}),
    ("control at 40 Hz", {"controller_rate": 40.0}, {}),
)
GONE = "board taken away"
REMOVED = {
    "surface.advance_distance": 2.0,
    "surface.advance_speed": 5.0,
    "surface.advance_start": 24.0,
    "surface.motion_direction": [1.0, 0.0, 0.0],
}
PARTS: tuple[tuple[str, Changes], ...] = (
    ("as it is", {}),
    ("vectoring angles for torque, not for contact", {"allocation.vectoring.purpose": "torque"}),
    ("torque thrusts that may lift", {"allocation.hold_lift": False}),
    ("no leak compensation", {"allocation.leak.compensate": False}),
    ("bias not fed forward", {"estimation.calibration.feed": False}),
    (
        "attitude and centre of gravity not calibrated",
        {"estimation.calibration.attitude": False, "estimation.calibration.cog": False},
    ),
    (
        "the paper's slow observer",
        {"estimation.observer.force": [3.0, 3.0, 3.0], "estimation.observer.torque": [1.0, 1.0, 1.0]},
    ),
    (
        "no delay compensation, no lead",
        {"estimation.delay.latency": 0.0, "allocation.rotor_lag.compensate": False},
    ),
    ("no lead on the rotors", {"allocation.rotor_lag.lead": 1.0}),
    ("friction not cancelled", {"translation.cancel": [0.0, 0.0]}),
    ("no force integral", {"translation.force_integral": 0.0}),
    ("as heavy as it is, mu = 1", {"translation.press_mass_ratio": 1.0}),
    ("presses on where the pen stays behind", {"contact.least_ease": 1.0}),
    ("no slope estimate", {"contact.surface.drift": 1e-9, "contact.surface.cross_noise": 1e6}),
    ("the arm does not recentre", {"shape.rate": 1e-6}),
    ("the centre of gravity follows, not the pen", {"translation.pen": 0.0}),
    ("the path does not slow down", {"contact.axis_speed": 10.0}),
    (
        "the paper's attitude gains",
        {
            "attitude.normalized_stiffness": [40.0, 40.0, 10.0],
            "attitude.damping_ratio": [1.1, 1.1, 0.8],
            "attitude.virtual_inertia_ratio": [10.0, 10.0, 5.0],
        },
    ),
    (
        "no small moves of the vectoring angles",
        {"allocation.law": "pseudoinverse", "allocation.hold_lift": True, "allocation.leak.steady": True},
    ),
    ("vectoring angles not led", {"allocation.vectoring.lead": 1.0, "allocation.vectoring.cutoff": 1.0}),
    ("calm body: the arm takes the surface's motion", {"shape.arm_share": 0.5}),
)


def draws(experiment: str, count: int, seed: int = SEED) -> Iterator[dict[str, Any]]:
    """Changes to an experiment, the same ones whatever flies it."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        drawn: dict[str, Any] = {
            "surface.friction": rng.uniform(0.1, 0.8),
            "surface.stiffness": 1000.0 * 20.0 ** rng.uniform(),
            "plant.thrust_scale": rng.uniform(0.98, 1.02),
            "plant.rotor_scale": rng.uniform(0.98, 1.02, 4).tolist(),
            "sensors.attitude_misalignment": np.radians(rng.uniform(-1.0, 1.0, 3)).tolist(),
            "plant.mass_scale": rng.uniform(0.99, 1.01),
            "plant.cog_offset": (0.01 * rng.uniform(-1.0, 1.0, 3)).tolist(),
            "sensors.latency": rng.uniform(0.01, 0.03),
            "trajectory.direction": int(rng.choice([1, -1])),
            "seed": int(rng.integers(1_000_000)),
        }
        slope = float(np.radians(rng.choice([-20.0, -14.0, 14.0, 20.0])))
        if experiment == "paper":
            drawn["surface.slope"] = slope
        if experiment == "friction_patches":
            del drawn["surface.friction"]
        yield drawn


def ensemble(
    experiment: str, count: int, controller: str = "following", gains: Changes = NONE, changes: Changes = NONE
) -> list[dict[str, Any]]:
    """Scores of every draw: metrics, status and cause."""
    robot = load_robot(load_experiment(experiment).robot)
    flown = load_controller(controller, robot, gains)
    scores: list[dict[str, Any]] = []
    ready: list[Takeoff] = []
    for index, drawn in enumerate(draws(experiment, count)):
        given = {**drawn, **changes}
        if given.pop("level cog", False):
            given["plant.cog_offset"] = [*given["plant.cog_offset"][:2], 0.0]
        if given.pop("cog", False):
            given["plant.cog_offset"] = [0.0, 0.0, 0.0]
        if given.pop("compass", False):
            # The measured link's third axis is vertical in flight.
            given["sensors.attitude_misalignment"] = [*given["sensors.attitude_misalignment"][:2], 0.0]
        ready.append(prepare(load_experiment(experiment, given), robot, flown))
        if len(ready) == CHUNK or index == count - 1:
            for takeoff, flight in zip(ready, fly_native(ready), strict=True):
                scores.append(scored(scored_run(takeoff, flight)))
            ready.clear()
    return scores


def scored(run: Run) -> dict[str, Any]:
    """Metrics of a run, and how far the pen moved on after the surface was taken away."""
    found = {**run.metrics, **measured(run, ["contact"]), "cause": run.cause}
    time = run.log.time.values
    start = float(REMOVED["surface.advance_start"])
    after = (time >= start) & (time < start + 3.0)
    x = run.log.tip_position.values[after, 0]
    found["caught"] = float(x.max() - x[0]) if len(x) else None
    off = found["force_error_percent"]
    found["force_off"] = None if off is None else off / 100.0
    return found


SHOWN = (
    ("CoG to mission u mm", "error_u_median", 1e3),
    ("v mm", "error_v_median", 1e3),
    ("pen to line rms mm", "pen_line_rms", 1e3),
    ("force N", "contact_force_normal_mean", 1.0),
    ("force std N", "force_slow_std", 1.0),
    ("near %", "near_fraction", 100.0),
    ("touch N", "touch_force_peak", 1.0),
    ("time s", "flight_time", 1.0),
    ("CoG to own target u mm", "target_error_u_median", 1e3),
    ("v mm", "target_error_v_median", 1e3),
    ("force off wanted %", "force_off", 100.0),
)
"""Columns: title, score, scale. The last three are only there for a law with a target and a wanted force."""


def row(name: str, scores: list[dict[str, Any]]) -> list[str]:
    """A line of a table: the flights that were lost, and median / worst decile of each score, if any."""
    kept = [score for score in scores if score["status"] == "OK"]
    cells = [name, f"{len(scores) - len(kept)} of {len(scores)}"]
    for _, key, scale in SHOWN:
        # A score that a flight does not have, such as the peak of a touch that never came, is None.
        known = [score[key] for score in kept if score.get(key) is not None]
        if not known:
            cells.append("")
            continue
        worst = 10.0 if key == "near_fraction" else 90.0
        middle, edge = (scale * float(np.percentile(known, at)) for at in (50.0, worst))
        cells.append(f"{middle:.{2 if scale == 1.0 else 1}f} / {edge:.{2 if scale == 1.0 else 1}f}")
    return cells


def table(rows: list[list[str]]) -> str:
    """A table in Markdown."""
    head = ["median / worst decile", "lost", *(name for name, _, _ in SHOWN)]
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def main() -> None:
    """Fly everything, keep the numbers, write the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--draws", type=int, default=200)
    parser.add_argument("--part-draws", type=int, default=48)
    parser.add_argument("--hybrid-draws", type=int, default=0, help="fewer for the hybrid; 0 for as many")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--tables", action="store_true", help="fly nothing: tables of docs/following.json")
    parser.add_argument("--only", default="", help="fly rows with this text; others of docs/following.json")
    options = parser.parse_args()
    if options.tables:
        kept = kept_numbers()
        write_tables(kept, kept["part_draws"])
        return
    numbers: dict[str, Any] = {"seed": SEED, "draws": options.draws, "part_draws": options.part_draws}
    counts = {"following": options.draws, "hybrid": options.hybrid_draws or options.draws}
    wanted: dict[str, tuple[Any, ...]] = {
        f"{name}: `{controller}`": (experiment, counts[controller], controller)
        for name, experiment in EXPERIMENTS
        for controller in counts
    }
    few = options.part_draws
    wanted |= {
        f"paper board, {name}": ("paper", few, "following", gains, changes) for name, changes, gains in HARDER
    }
    wanted |= {GONE: ("paper", few, "following", {}, REMOVED)}
    wanted |= {name: ("paper", few, "following", gains) for name, gains in PARTS}
    kept = kept_numbers() if options.only else {}
    with ProcessPoolExecutor(options.workers) as pool:
        jobs = {name: pool.submit(ensemble, *what) for name, what in wanted.items() if options.only in name}
        for name in wanted:
            numbers[name] = jobs[name].result() if name in jobs else kept[name]
            (DOCS / "following.json").write_text(compact(numbers), encoding="utf-8")
            print(" | ".join(row(name, numbers[name])), flush=True)
    write_tables(numbers, few)


def write_tables(numbers: Mapping[str, Any], few: int) -> None:
    """Put both tables into the page."""
    parts = [name for name, _ in PARTS]
    flown = [name for name, scores in numbers.items() if isinstance(scores, list)]
    rows = [row(name, numbers[name]) for name in flown if name not in parts and name != GONE]
    fill(PAGE, "table", f"{table(rows)}\n\n{caught(numbers[GONE])}")
    fill(
        PAGE,
        "parts",
        f"On the paper's board, {few} draws.\n\n{table([row(name, numbers[name]) for name in parts])}",
    )


def kept_numbers() -> dict[str, Any]:
    """What docs/following.json holds, an ensemble as a list of scores again."""
    kept = json.loads((DOCS / "following.json").read_text(encoding="utf-8"))
    return {
        key: [dict(zip(value, scores, strict=True)) for scores in zip(*value.values(), strict=True)]
        if isinstance(value, dict)
        else value
        for key, value in kept.items()
    }


def beside_table(numbers: Mapping[str, Any]) -> list[str]:
    """Both presets on every surface, by what they share; docs/reports/results.md shows it."""
    shared = SHOWN[:6]
    lines = ["| surface | preset | lost | " + " | ".join(name for name, _, _ in shared) + " |"]
    lines.append("|---" * (3 + len(shared)) + "|")
    for name, _ in EXPERIMENTS:
        for controller in ("following", "hybrid"):
            _, lost, *cells = row("", numbers[f"{name}: `{controller}`"])
            lines.append(f"| {name} | `{controller}` | {lost} | " + " | ".join(cells[: len(shared)]) + " |")
    return lines


def caught(scores: list[dict[str, Any]]) -> str:
    """A sentence on the board that was taken away."""
    ways = [score["caught"] for score in scores if score["caught"] is not None]
    middle, worst = (1e3 * float(np.percentile(ways, at)) for at in (50, 90))
    lost = sum(score["status"] != "OK" for score in scores)
    return (
        f"The board taken away in the middle of the slide ({len(scores)} draws): the tip moves on by "
        f"{middle:.0f} mm (median) and {worst:.0f} mm (worst decile) before it is caught; {lost} are lost."
    )


def compact(numbers: Mapping[str, Any]) -> str:
    """JSON with four digits a number and a line an ensemble, in columns of numbers and words.

    What the verdict says of each flight at length is left out: no table has it, and it is most of the bytes.
    """

    def short(value: Any) -> Any:
        return float(f"{value:.4g}") if isinstance(value, float) else value

    lines = []
    for key, kept in numbers.items():
        value = kept
        if isinstance(kept, list):
            plain = [name for name in kept[0] if not any(isinstance(s.get(name), list | dict) for s in kept)]
            value = {name: [short(score.get(name)) for score in kept] for name in plain if name != "missed"}
        lines.append(f"{json.dumps(key)}: {json.dumps(value)}")
    return "{\n" + ",\n".join(lines) + "\n}\n"


if __name__ == "__main__":
    main()
