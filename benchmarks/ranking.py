"""All controllers on one bench: who draws, who presses, who is lost, and what a tick costs.

    python benchmarks/ranking.py [--draws 200] [--out out/ranking] [--only paper] [--tables]

Every place is a campaign (`PLACES`): all controllers meet the same draws, of robots that are calibrated, with
noise, delays and rotors that turn the robot. They fly with the gains that ship; nothing was tuned on these
draws. A lost flight counts as infinitely bad. Ranks are a campaign's: two controllers whose difference an
exact sign test does not tell at 95 % share one. docs/rivals.json keeps the numbers; the tables of
docs/rivals.md are written anew.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from kept import fill  # beside this file

from skylimb.base.config import from_mapping
from skylimb.flight.drivers.native import compile_native, fly_native
from skylimb.flight.takeoff import take_off
from skylimb.studies.campaign.fly_campaign import run_campaign
from skylimb.studies.campaign.spec import CampaignSpec
from skylimb.studies.campaign.who_wins import fails_where, shown_ranks

DOCS = Path(__file__).parents[1] / "docs"
PAGE, NUMBERS = DOCS / "rivals.md", DOCS / "rivals.json"
SEED = 34
CONTENDERS = ("pid", "impedance", "admittance", "hybrid", "following", "drawing", "mpc")
PLACES = {
    "paper": "the paper's circle on a leaning board",
    "cylinder_convex": "a circle on a cylinder that bulges",
    "sine_gentle": "a circle on waves",
    "push_and_slide": "pushes along a wall",
    "calligraphy": "a word whose strokes are pressed harder and softer",
    "writing": "letters of some millimetres",
}
VARY: dict[str, dict[str, Any]] = {
    "surface.friction": {"uniform": [0.1, 0.6]},
    "surface.stiffness": {"log_uniform": [1e3, 2e4]},
    "plant.mass_scale": {"uniform": [0.99, 1.01]},
    "plant.cog_offset": {"uniform": [-0.001, 0.001], "size": 3},
    "plant.rotor_scale": {"uniform": [0.99, 1.01], "size": 4},
    "plant.rotor_inertia": {"uniform": [1.4e-4, 2.6e-4]},
    "sensors.attitude_misalignment": {"uniform": [-0.002, 0.002], "size": 3},
    "sensors.latency": {"uniform": [0.01, 0.03]},
}
"""As of a robot once it is calibrated; see benchmarks/tasks.py."""
COLUMNS = (
    ("line, rms mm", "pen_line_rms", 1e3),
    ("force, std N", "contact_force_normal_std", 1.0),
    ("force, rms off the commanded N", "force_error_rms", 1.0),
    ("in touch", "contact_fraction", 1.0),
)


def flown(place: str, draws: int, out: Path) -> list[dict[str, Any]]:
    """What a place's campaign says of each controller."""
    given = {
        "experiment": place,
        "controllers": list(CONTENDERS),
        "draws": draws,
        "seed": SEED,
        "logs": "none",
        "score": "pen_line_rms",
        "vary": VARY,
    }
    folder = out / place
    outcome = run_campaign(
        from_mapping(CampaignSpec, given, "ranking"), folder, workers=0, resume=folder.exists()
    )
    summary, rows = outcome.summary, list[dict[str, Any]]()
    if summary is None:
        raise SystemExit("stopped; what was flown is kept")
    for index, name in enumerate(CONTENDERS):
        row: dict[str, Any] = {"place": place, "controller": name, "draws": len(summary.scores.draws)}
        row["lost"] = sum(one["controller"] == name for one in summary.lost)
        row["fails"] = fails_where(summary, name, "loss")
        for _, key, _ in COLUMNS:
            row[key] = [float(number) for number in summary.medians[key][index]]
            row[f"{key} rank"] = shown_ranks(summary.ranks.get(key, [0] * len(CONTENDERS)))[index]
        rows.append(row)
    return rows


def cost(name: str, more: Mapping[str, Any] = MappingProxyType({})) -> float:
    """What a tick of a flight costs, us: closed loop, physics and all, on one thread.

    Args:
        name: of the controller.
        more: what else is different from the paper's experiment.
    """
    short = {"supervisor.on": False, "phases.hover": 0.5, "phases.tare": 1.0}
    (takeoff,) = take_off("paper", (name,), 0, {**short, **more})
    compile_native(takeoff.tick.function)
    times = []
    for _ in range(3):
        begin = time.perf_counter()
        (flight,) = fly_native([takeoff], 1)
        times.append((time.perf_counter() - begin) / flight.ticks)
    return 1e6 * min(times)


def table(rows: Sequence[dict[str, Any]], costs: dict[str, float]) -> str:
    """Medians with their 95 % intervals, and ranks where the draws tell anybody apart."""
    head = ("controller", "lost", *(title for title, *_ in COLUMNS))
    parts = []
    for place, what in PLACES.items():
        own = [row for row in rows if row["place"] == place]
        if not own:
            continue
        lines = [f"**`{place}`**, {what}; {own[0]['draws']} draws each", ""]
        lines += ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
        for row in own:
            cells = [f"`{row['controller']}`", str(row["lost"])]
            for _, key, scale in COLUMNS:
                middle, low, high = (_said(scale * number) for number in row[key])
                rank = f" ({row[f'{key} rank']})" if row[f"{key} rank"] else ""
                cells.append(middle if middle in ("-", "lost") else f"{middle} [{low}, {high}]{rank}")
            lines.append("| " + " | ".join(cells) + " |")
        fails = [f"- `{row['controller']}`: {row['fails']}." for row in own if row["lost"]]
        lines += ["", *fails] if fails else []
        parts.append("\n".join(lines))
    lines = ["| controller | a tick, us |", "|---|---|"]
    lines += [f"| `{name}` | {number:.0f} |" for name, number in costs.items()]
    return "\n\n".join([*parts, "\n".join(lines)])


def _said(number: float) -> str:
    """A median or an end of its interval; a lost flight is infinitely bad."""
    return "-" if np.isnan(number) else f"{number:.3g}" if np.isfinite(number) else "lost"


def main() -> None:
    """Fly what is missing, keep it, write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--draws", type=int, default=200)
    parser.add_argument("--out", type=Path, default=Path("out/ranking"))
    parser.add_argument("--only", nargs="*", default=list(PLACES), choices=list(PLACES))
    parser.add_argument("--tables", action="store_true", help="fly nothing: the tables of docs/rivals.json")
    options = parser.parse_args()
    kept = json.loads(NUMBERS.read_text(encoding="utf-8")) if NUMBERS.exists() else {"rows": [], "costs": {}}
    if not options.tables:
        for place in options.only:
            rows = flown(place, options.draws, options.out)
            kept["rows"] = [row for row in kept["rows"] if row["place"] != place] + rows
            NUMBERS.write_text(json.dumps(kept, indent=0), encoding="utf-8")
        kept["costs"] = {name: cost(name) for name in CONTENDERS}
        NUMBERS.write_text(json.dumps(kept, indent=0), encoding="utf-8")
    fill(PAGE, "ranking", table(kept["rows"], kept["costs"]))
    print(table(kept["rows"], kept["costs"]))


if __name__ == "__main__":
    main()
