"""Measure what else a user might fly with, each in an environment of its own, beside skylimb; see docs.

    make bench-rivals          (or: python benchmarks/compare.py)

The environments are made below out/rivals/ on first use, 2 GB and more. A rival that cannot be installed gets
a row that says why. They simulate different things, so the table says what; `RIVALS` holds the words.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

HERE = Path(__file__).parent / "rivals"
CACHE = Path(__file__).parents[1] / "out" / "rivals"
INSTALL_SECONDS, FLY_SECONDS = 1800, 900


@dataclass(frozen=True)
class Rival:
    """Something to fly with.

    Attributes:
        name: as its authors write it.
        stem: of its files in rivals/: STEM.txt, and fly_STEM.py where it could be tried.
        simulates: what a step computes.
        contact: with what.
        loop: what the controller is written in, and what it does.
        rates: of physics and control.
        batches: flights at once that are tried.
    """

    name: str
    stem: str
    simulates: str
    contact: str
    loop: str
    rates: str
    batches: tuple[int, ...] = ()


SKYLIMB = Rival(
    "skylimb",
    "skylimb",
    "8 bodies with 7 servo joints, rotor lag, sensors with noise and latency, a record of 99 numbers a tick",
    "pen on a board, elliptic friction cone",
    "the paper's cascade with observer and allocation; from Python, or compiled",
    "1000 Hz, 200 Hz",
    (8,),
)

RIVALS = (
    Rival(
        "RotorPy",
        "rotorpy",
        "one rigid body, motor lag, aerodynamic drag, sensors with noise",
        "none",
        "SE(3) controller in Python (NumPy; PyTorch for many)",
        "one step of an adaptive (many: fixed) Runge-Kutta method at 100 Hz, 100 Hz",
        (16, 64, 256),
    ),
    Rival(
        "crazyflow",
        "crazyflow",
        "one rigid body, identified rotor dynamics; no sensors, no record",
        "none in the dynamics (the floor clips the height)",
        "Mellinger's controller, compiled by JAX; Python sends set points",
        "500 Hz (Euler, single precision), position 100 Hz, attitude 500 Hz",
        (64, 1024, 4096),
    ),
    Rival(
        "gym-pybullet-drones",
        "gym_pybullet_drones",
        "one rigid body in Bullet",
        "Bullet's",
        "cascaded PID in Python",
        "240 Hz, 48 Hz",
    ),
)


def measure(repeats: int) -> list[dict[str, Any]]:
    """A row for each way to fly."""
    rows = _rows(SKYLIMB, _flown(SKYLIMB, sys.executable, repeats))
    for rival in RIVALS:
        python, problem = environment(rival.stem)
        if not problem and not rival.batches:
            problem = "it can be installed here, but nobody has written its flight"
        rows += _rows(rival, {"problem": problem} if problem else _flown(rival, str(python), repeats))
    return rows


def environment(stem: str) -> tuple[Path, str]:
    """The Python of an environment with the pinned versions, made if it is missing; or why it cannot be."""
    wanted = HERE / f"{stem}.txt"
    digest = hashlib.sha256(wanted.read_bytes() + sys.version.encode()).hexdigest()[:12]
    folder = CACHE / f"{stem}-{digest}"
    python = folder / ("Scripts" if sys.platform == "win32" else "bin") / "python"
    if (folder / "done").exists():
        return python, ""
    print(f"installing {stem} into {folder}", file=sys.stderr, flush=True)
    shutil.rmtree(folder, ignore_errors=True)
    commands = (
        [sys.executable, "-m", "venv", str(folder)],
        [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r", str(wanted)],
    )
    for command in commands:
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, timeout=INSTALL_SECONDS, check=False
            )
        except subprocess.TimeoutExpired:
            return python, f"its installation took more than {INSTALL_SECONDS} s"
        if done.returncode != 0:
            said = [line for line in done.stderr.splitlines() if line.startswith("ERROR")]
            return python, "cannot be installed: " + " ".join((said or ["no message"])[-1].split())
    (folder / "done").touch()
    return python, ""


def answer(python: str, script: str, **options: Any) -> dict[str, Any]:
    """What a script of rivals/ prints last; or a `problem`, why it printed nothing."""
    command = [python, str(HERE / script), json.dumps(options)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=FLY_SECONDS, check=False)
        if done.returncode == 0:
            return json.loads(done.stdout.splitlines()[-1])
    except subprocess.TimeoutExpired:
        return {"problem": f"it took more than {FLY_SECONDS} s"}
    return {"problem": f"it failed: {(done.stderr.strip() or 'no message').splitlines()[-1]}"}


def _flown(rival: Rival, python: str, repeats: int) -> dict[str, Any]:
    return answer(python, f"fly_{rival.stem}.py", repeats=repeats, batches=rival.batches)


def _rows(rival: Rival, found: dict[str, Any]) -> list[dict[str, Any]]:
    """What was found as plain rows: simulated seconds a wall second, and control ticks a second."""
    head = {
        "name": rival.name,
        "simulates": rival.simulates,
        "contact": rival.contact,
        "loop": rival.loop,
        "rates": rival.rates,
        "versions": [] if rival is SKYLIMB else (HERE / f"{rival.stem}.txt").read_text().split(),
    }
    if "problem" in found:
        return [{**head, "problem": found["problem"]}]
    rate, rows = found["control_rate"], []
    for way, flown in found.get("rows", {"": found}).items():
        one = flown["one"]["simulated"] / flown["one"]["wall"]
        best = max(flown["many"], key=lambda run: run["simulated"] / run["wall"], default=None)
        row = {**head, "way": way, "one": one, "one_ticks": one * rate}
        if best:
            many = best["simulated"] / best["wall"]
            row |= {"flights": best["flights"], "many": many, "many_ticks": many * rate}
        rows.append(row)
    return rows


def table(rows: list[dict[str, Any]]) -> list[str]:
    """The figures as a table in Markdown."""
    lines = [
        "| | one flight: simulated s / s | control ticks / s | at once: flights | simulated s / s "
        "| control ticks / s |",
        "|---|---|---|---|---|---|",
    ]
    for row in rows:
        name = f"{row['name']}, {row['way']}" if row.get("way") else row["name"]
        if "problem" in row:
            lines.append(f"| {name} | {row['problem']} | | | | |")
            continue
        many = "| | | |"
        if "many" in row:
            many = f"| {row['flights']} | {row['many']:,.0f} | {row['many_ticks']:,.0f} |"
        lines.append(f"| {name} | {row['one']:,.1f} | {row['one_ticks']:,.0f} {many}")
    return lines


def described(rows: list[dict[str, Any]]) -> list[str]:
    """What each simulates, as a table in Markdown."""
    lines = ["| | simulates | contact | controller | physics, control |", "|---|---|---|---|---|"]
    for row in {row["name"]: row for row in rows}.values():
        lines.append(
            f"| {row['name']} | {row['simulates']} | {row['contact']} | {row['loop']} | {row['rates']} |"
        )
    return lines


def main() -> int:
    """Print both tables; with --json, the rows."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    rows = measure(options.repeats)
    if options.json:
        print(json.dumps(rows, indent=2))
    else:
        Console(highlight=False, soft_wrap=True).print(
            "\n".join([*described(rows), "", *table(rows)]), markup=False
        )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
