"""How fast the closed loop is on every robot that ships, against a raw replay of its own controls.

    python benchmarks/robots_speed.py [--repeats 7] [--write]

Each robot flies the board that ships for it with the presets `hybrid` and `following`, by the Python driver
(benchmarks/loop.py) and by the native one (benchmarks/native.py). `--write` puts the table into
docs/reports/robots.md. Run it on an idle machine. Exits with 1 when a ratio falls short of 0.90 and 1.00.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from itertools import cycle
from pathlib import Path
from typing import NamedTuple

import loop
import native  # beside this file, as `loop` is

PAGE = Path(__file__).parents[1] / "docs" / "reports" / "robots.md"
EXPERIMENTS = (
    "paper",
    "ceiling",
    "board_hydrus_xi_hex",
    "board_hydrus_quad",
    "board_dragon",
    "board_tilted_hexarotor",
    "board_tiltable_hexarotor",
)
CONTROLLERS = ("hybrid", "following")
WANTED = (0.90, 1.00)


class Row(NamedTuple):
    """Closed loop over raw replay, in speed: of each of `CONTROLLERS` by the Python and the native driver."""

    robot: str
    experiment: str
    ratios: tuple[float, ...]


def measured(experiment: str, repeats: int) -> Row:
    """A robot's flights, timed."""
    robot, ratios = "", []
    for controller in CONTROLLERS:
        _, figures = loop.measure(experiment, controller, repeats)
        takeoff = native.prepare(experiment, controller)
        closed, raw, _ = native.closed_over_replay(takeoff, repeats)
        robot, ratios = takeoff.robot.name, [*ratios, figures.ratio, raw / closed]
    return Row(robot, experiment, tuple(ratios))


def table(rows: Sequence[Row]) -> str:
    """One robot a line."""
    heads = [f"`{name}`: {driver}" for name in CONTROLLERS for driver in ("Python", "native")]
    lines = [f"| robot | experiment | {' | '.join(heads)} |", "|---" * (2 + len(heads)) + "|"]
    for row in rows:
        ratios = " | ".join(f"{ratio:.2f}" for ratio in row.ratios)
        lines.append(f"| `{row.robot}` | `{row.experiment}` | {ratios} |")
    return "\n".join(lines)


def main() -> int:
    """Measure all; 1 when one falls short."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--write", action="store_true", help="put the table into docs/reports/robots.md")
    options = parser.parse_args()
    rows = []
    for name in EXPERIMENTS:
        rows.append(measured(name, options.repeats))
        print(rows[-1], flush=True)
    print(table(rows))
    if options.write:
        text = PAGE.read_text(encoding="utf-8")
        begin, end = "<!-- begin: speed -->", "<!-- end: speed -->"
        new = f"{begin}\n\n{table(rows)}\n\n{end}"
        PAGE.write_text(re.sub(f"{begin}.*?{end}", lambda _: new, text, flags=re.DOTALL), encoding="utf-8")
    short = [ratio < wanted for row in rows for ratio, wanted in zip(row.ratios, cycle(WANTED), strict=False)]
    return int(any(short))


if __name__ == "__main__":
    raise SystemExit(main())
