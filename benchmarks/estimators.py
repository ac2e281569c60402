"""What each estimator makes of the same flights: lag, noise, bias, touch and cost; and what it flies like.

    python benchmarks/estimators.py [--draws 20] [--only PART ...] [--of NAME ...] [--tables]

`following` flies every flight with the estimation that it ships with. Each estimator then works on its log
(`skylimb.replay`): the same measurements, the same thrusts. Draws are those of benchmarks/following.py with
another seed, of robots that do not know themselves; the robot has an IMU, and each estimator says whether it
looks at it. Parts:

- open: the paper's board, and a hover with pushes;
- bias: one thing at a time is not as modelled;
- speeds: each estimator faster and slower, for its noise at the same lag;
- closed: `following` flies with each;
- cost: of a tick.

`--of` works with some estimators alone, and keeps the numbers of all others, of the same flights.
docs/estimators.json keeps every number; the tables of docs/reports/estimators.md are written anew.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from following import draws  # beside this file, as the next two
from kept import fill, keep
from ranking import cost

import skylimb
from skylimb.analysis.scores.estimate import LASTS, tared
from skylimb.analysis.scores.registry import measured
from skylimb.analysis.scores.signals import contact_axis, in_contact, spans
from skylimb.control.controller import load_controller
from skylimb.control.laws.traced_step import traced_step
from skylimb.robots.loader import load_robot

HERE = Path(__file__).parent
DOCS = HERE.parent / "docs"
PAGE, NUMBERS = DOCS / "reports" / "estimators.md", DOCS / "estimators.json"
SEED, SPEED_DRAWS = 3400, 4  # no gain was chosen on these draws
Changes = Mapping[str, Any]
Names = Sequence[str] | None
"""Which estimators; None for all."""

LAW = "estimation.law"
MOMENTUM: Changes = {
    LAW: "momentum",
    "estimation.smoothing.on": False,
    "estimation.observer.force": [3.0, 3.0, 3.0],
    "estimation.observer.torque": [1.0, 1.0, 1.0],
}
ESTIMATORS: Mapping[str, Changes] = {
    "momentum": MOMENTUM,
    "extended_state": {LAW: str(HERE.parent / "examples" / "laws" / "extended_state.py")},
    "predictive": {},
    "kalman": {LAW: "kalman"},
    "moving_horizon": {LAW: "moving_horizon"},
    "predictive, IMU": {"estimation.smoothing.imu": True},
    "kalman, IMU": {LAW: "kalman", "estimation.imu.on": True},
}
"""What each changes in the preset `following`, whose other gains they share where they have them."""

SPEEDS = (0.5, 1.0, 2.0)
FORCES = {
    "momentum": ("estimation.observer.force", 3.0),
    "extended_state": ("estimation.bandwidth", 6.0),
    "predictive": ("estimation.observer.force", 5.0),
    "kalman": ("estimation.spread.force", 0.35),
    "moving_horizon": ("estimation.window.force", 0.15),
}
"""The gain that makes each faster, as it is."""
SAME_LAG = 0.2
"""At which noise is compared, s."""

WRONG: Mapping[str, Changes] = {
    "nothing": {},
    "mass +3 %": {"plant.mass_scale": 1.03},
    "thrust -3 %": {"plant.thrust_scale": 0.97},
    "centre of gravity 10 mm along x": {"plant.cog_offset": [0.01, 0.0, 0.0]},
    "attitude 1 degree about y": {"sensors.attitude_misalignment": [0.0, float(np.radians(1.0)), 0.0]},
}
TORQUE: Changes = {"estimation.spread.torque": 0.1}
CLOSED: Mapping[str, Changes] = {
    "predictive": {},
    "kalman": {},
    "kalman, torque 0.1": TORQUE,
    "moving_horizon": {},
    "predictive, IMU": {},
    "kalman, IMU": {},
    "kalman, IMU, torque 0.1": TORQUE,
}
"""What flies; the torque's drift of `kalman` suits the paper's controllers; `following` wants more."""
FLOWN = (
    ("force, std N", "force_slow_std", 1.0),
    ("line, rms mm", "pen_line_rms", 1e3),
    ("first touch, N", "touch_force_peak", 1.0),
    ("losses", "contact_losses", 1.0),
)


def changes_of(name: str, speed: float = 1.0) -> dict[str, Any]:
    """What an estimator changes in the preset, at a share of its own speed."""
    changes = {**ESTIMATORS[name.removesuffix(", torque 0.1")], **CLOSED.get(name, {})}
    if speed != 1.0:
        key, value = FORCES[name.partition(",")[0]]
        # A filter's bandwidth goes with the root of the drift that it allows for.
        faster = value * (speed**2 if "spread" in key or "window" in key else speed)
        changes[key] = [faster] * 3 if key.endswith("observer.force") else faster
        if "smoothing" not in str(changes) and key.endswith("observer.force"):
            changes["estimation.smoothing.velocity"] = 25.0 * speed
    return {f"controller.{key}": value for key, value in changes.items()}


def pushes(seed: int) -> list[dict[str, Any]]:
    """Pushes of 0.5 to 2 N along the axes, one after the other."""
    rng, time, found = np.random.default_rng(seed), 7.0, []
    while time < 24.0:
        length, force = float(rng.uniform(0.3, 1.2)), np.zeros(3)
        force[rng.integers(3)] = rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 2.0)
        found.append(
            {"kind": "push", "time": round(time, 3), "duration": round(length, 3), "force": force.tolist()}
        )
        time += length + float(rng.uniform(0.2, 0.8))
    return found


def flights(count: int) -> Iterator[tuple[int, str, skylimb.Run]]:
    """The flights that all estimators work on: number, kind, run."""
    for number, drawn in enumerate(draws("paper", count, SEED)):
        own = {key: value for key, value in drawn.items() if key.partition(".")[0] != "surface"}
        own.pop("trajectory.direction")
        yield number, "board", flown("paper", drawn)
        yield number, "pushes", flown("push", own | {"events": pushes(number)})


def flown(experiment: str, changes: Changes) -> skylimb.Run:
    return skylimb.run(experiment, "following", set={"sensors.imu.on": True, **changes})


def seen(run: skylimb.Run, name: str, speed: float = 1.0) -> skylimb.Run:
    """What an estimator makes of a flight."""
    return skylimb.replay(run, "following", set=changes_of(name, speed))


def touch_without_false(run: skylimb.Run) -> tuple[float, float]:
    """The least threshold that the approach does not pass, N, and how late a touch passes it, s."""
    log = run.log
    time, along = log.time.values, -contact_axis(log).along(log.external_force_estimate.values)
    touching = in_contact(log)
    if not touching.any():
        return np.nan, np.nan
    first = int(np.argmax(touching))
    before = along[tared(log) & (np.arange(len(time)) < first)]
    least = float(before.max())
    felt = [begin for begin, end in spans(time, along > least) if end - begin >= LASTS and end > time[first]]
    return least, (max(felt[0] - time[first], 0.0) + LASTS if felt else np.nan)


def among(known: Mapping[str, Changes], names: Names) -> list[str]:
    return [name for name in known if names is None or name in names]


def opened(count: int, names: Names) -> Iterator[dict[str, Any]]:
    """Scores of every estimator on every flight."""
    for number, kind, run in flights(count):
        for name in among(ESTIMATORS, names):
            again = seen(run, name)
            row = {"part": "open", "draw": number, "kind": kind, "estimator": name}
            row |= {
                key.removeprefix("estimate_"): value for key, value in measured(again, ["estimate"]).items()
            }
            if kind == "board":
                row["threshold"], row["late_without_false"] = touch_without_false(again)
            yield row


def biased(count: int, names: Names) -> Iterator[dict[str, Any]]:
    """What the tare takes off, and what is left of the error in contact."""
    for what, wrong in WRONG.items():
        for seed in range(max(count // 7, 1)):
            run = flown("paper", {**wrong, "seed": SEED + seed})
            for name in among(ESTIMATORS, names):
                again = seen(run, name)
                log = again.log
                off = log.external_force_bias.values[tared(log)][0]
                row = {"part": "bias", "wrong": what, "draw": seed, "estimator": name}
                yield row | {
                    "tare": float(np.linalg.norm(off)),
                    "left": measured(again, ["estimate"])["estimate_bias"],
                }


def sped(count: int, names: Names) -> Iterator[dict[str, Any]]:
    """Lag and noise of each at other speeds, in a hover with pushes."""
    for number, kind, run in flights(min(count, SPEED_DRAWS)):
        for name in among(ESTIMATORS, names) if kind == "pushes" else ():
            for speed in SPEEDS:
                found = measured(seen(run, name, speed), ["estimate"])
                row = {"part": "speeds", "draw": number, "estimator": name, "speed": speed}
                yield row | {"lag": found["estimate_lag"], "noise": found["estimate_noise"]}


def closed(count: int, names: Names) -> Iterator[dict[str, Any]]:
    """`following` flies the board with each."""
    for number, drawn in enumerate(draws("paper", count, SEED)):
        for name in among(CLOSED, names):
            run = flown("paper", {**drawn, **changes_of(name)})
            found = {**run.metrics, **measured(run, ["contact"])}
            row = {
                "part": "closed",
                "draw": number,
                "estimator": name,
                "lost": run.cause if run.failed else "",
            }
            yield row | {key: found[key] for _, key, _ in FLOWN}


def costs(count: int, names: Names) -> Iterator[dict[str, Any]]:
    """A tick of a flight with each, the least of a few; and operations of a controller's tick, counted."""
    robot = load_robot("hydrus_xi_quad")
    for name in among(ESTIMATORS, names):
        changes = changes_of(name)
        own = {key.removeprefix("controller."): value for key, value in changes.items()}
        step = traced_step(load_controller("following", robot, own), 1.0 / 200.0).function
        row = {"part": "cost", "draw": 0, "estimator": name, "operations": int(step.n_instructions())}
        yield row | {"tick": round(cost("following", {"sensors.imu.on": "IMU" in name, **changes}))}


PARTS = {"open": opened, "bias": biased, "speeds": sped, "closed": closed, "cost": costs}


def numbers(rows: Sequence[Changes], key: str) -> np.ndarray:
    return np.array([row[key] for row in rows if row.get(key) is not None], dtype=float)


def middle(values: np.ndarray, scale: float = 1.0, digits: int = 3) -> str:
    """Median and worst decile."""
    values = values[np.isfinite(values)]
    if not len(values):
        return "-"
    return " / ".join(
        f"{value:.0f}" if value >= 100.0 else f"{value:.{digits}g}"
        for value in np.percentile(scale * values, [50, 90])
    )


def own(rows: Sequence[Changes], **wanted: Any) -> list[Changes]:
    return [row for row in rows if all(row.get(key) == value for key, value in wanted.items())]


def same_lag(rows: Sequence[Changes], name: str) -> str:
    """Noise at `SAME_LAG`, on the straight line between speeds in logarithms."""
    points = []
    for speed in SPEEDS:
        some = own(rows, part="speeds", estimator=name, speed=speed)
        if some:
            points.append((np.median(numbers(some, "lag")), np.median(numbers(some, "noise"))))
    points.sort()
    if len(points) < 2:
        return "-"
    lags, noises = np.log(np.transpose(points))
    at = np.log(SAME_LAG)
    if not lags[0] <= at <= lags[-1]:
        return "-"
    k = int(np.clip(np.searchsorted(lags, at) - 1, 0, len(lags) - 2))
    slope = (noises[k + 1] - noises[k]) / (lags[k + 1] - lags[k])
    return f"{np.exp(noises[k] + slope * (at - lags[k])):.3f}"


def table(head: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    return "\n".join("| " + " | ".join(line) + " |" for line in (head, ["---"] * len(head), *lines))


def wrench_table(rows: Sequence[Changes]) -> str:
    lines = []
    for name in ESTIMATORS:
        board, hover = (own(rows, part="open", kind=kind, estimator=name) for kind in ("board", "pushes"))
        timed = own(rows, part="cost", estimator=name)
        lines.append(
            (
                f"`{name}`",
                middle(numbers(hover, "lag"), 1e3),
                f"{0.5 / np.pi / np.median(numbers(hover, 'lag')):.2f}" if hover else "-",
                middle(numbers(hover, "noise"), 1e3),
                f"{1e3 * float(same_lag(rows, name)):.0f}" if same_lag(rows, name) != "-" else "-",
                middle(numbers(hover, "error_rms")),
                middle(numbers(board, "error_rms")),
                middle(abs(numbers(board, "bias")), 1e3),
                f"{timed[0]['tick'] or '-'}, {timed[0]['operations']}" if timed else "-",
            )
        )
    head = (
        "estimator",
        "lag, ms",
        "bandwidth, Hz",
        "noise, mN",
        f"noise at {1e3 * SAME_LAG:.0f} ms, mN",
        "error under pushes, N",
        "error on the board, N",
        "bias on the board, mN",
        "a tick, us, and operations",
    )
    return table(head, lines)


def touch_table(rows: Sequence[Changes]) -> str:
    lines = []
    for name in ESTIMATORS:
        board = own(rows, part="open", kind="board", estimator=name)
        late = numbers(board, "touch_late")
        lines.append(
            (
                f"`{name}`",
                middle(late, 1e3),
                f"{len(board) - len(late)} of {len(board)}",
                f"{int(np.sum(numbers(board, 'false_touches')))}",
                middle(numbers(board, "threshold")),
                middle(numbers(board, "late_without_false"), 1e3),
            )
        )
    head = (
        "estimator",
        "touch late, ms",
        "never",
        "false touches, all flights",
        "least threshold without a false one, N",
        "late at that threshold, ms",
    )
    return table(head, lines)


def bias_table(rows: Sequence[Changes]) -> str:
    lines = []
    for what in WRONG:
        cells = [what]
        for name in ESTIMATORS:
            some = own(rows, part="bias", wrong=what, estimator=name)
            cells.append(
                f"{np.median(numbers(some, 'tare')):.2f}, {1e3 * np.median(numbers(some, 'left')):+.0f}"
                if some
                else "-"
            )
        lines.append(cells)
    return table(("not as modelled", *(f"`{name}`" for name in ESTIMATORS)), lines)


def flown_table(rows: Sequence[Changes]) -> str:
    lines = []
    for name in CLOSED:
        some = own(rows, part="closed", estimator=name)
        cells = [f"`{name}`", f"{sum(bool(row['lost']) for row in some)} of {len(some)}"]
        for _, key, scale in FLOWN:
            cells.append(f"{middle(numbers(some, key), scale)}{wins(rows, name, key)}")
        lines.append(cells)
    return table(("`following` with", "lost", *(title for title, *_ in FLOWN)), lines)


def wins(rows: Sequence[Changes], name: str, key: str) -> str:
    """On how many draws it is better than `predictive` with the same sensors."""
    rival = "predictive, IMU" if "IMU" in name else "predictive"
    if name == rival:
        return ""
    mine, other = (
        {row["draw"]: row[key] for row in own(rows, part="closed", estimator=one) if row[key] is not None}
        for one in (name, rival)
    )
    both = mine.keys() & other.keys()
    return f" ({sum(mine[draw] < other[draw] for draw in both)} of {len(both)})"


TABLES = {"wrench": wrench_table, "touch": touch_table, "bias": bias_table, "flown": flown_table}


def main() -> None:
    """Fly and replay what is asked for, keep it, write the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--only", nargs="*", default=list(PARTS), choices=list(PARTS), help="parts made anew")
    parser.add_argument(
        "--tables", action="store_true", help="fly nothing: the tables of docs/estimators.json"
    )
    parser.add_argument("--of", nargs="*", choices=[*ESTIMATORS, *CLOSED], help="some estimators alone")
    options = parser.parse_args()
    rows: list[dict[str, Any]] = json.loads(NUMBERS.read_text(encoding="utf-8")) if NUMBERS.exists() else []
    for part in () if options.tables else options.only:
        known = options.of or {*ESTIMATORS, *CLOSED}
        rows = [row for row in rows if row["part"] != part or row["estimator"] not in known]
        for row in PARTS[part](options.draws, options.of):
            rows.append(row)
            keep(NUMBERS, rows)
            print(row, flush=True)
    for name, made in TABLES.items():
        fill(PAGE, name, made(rows))
        print(made(rows), end="\n\n")


if __name__ == "__main__":
    main()
