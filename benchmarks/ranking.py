"""All controllers on one bench: who draws, who presses, who is lost, and what a tick costs.

    python benchmarks/ranking.py [--draws 200] [--out out/ranking] [--only paper] [--tables] [--costs]

Every place is a campaign (`PLACES`): all its controllers meet the same draws, with noise, delays and rotors
that turn the robot; of robots that are calibrated, but where it says otherwise. They fly with the gains that
ship; nothing was tuned on these draws. A lost flight counts as infinitely bad. Ranks are a campaign's: two
controllers whose difference an exact sign test does not tell at 95 % share one. docs/rivals.json keeps the
numbers; the tables of docs/reports/rivals.md are written anew. `--costs` times a tick of each, on an idle
machine.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
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
from skylimb.studies.campaign.tuning.tune_gains import tune
from skylimb.studies.campaign.who_wins import fails_where, shown_ranks

DOCS = Path(__file__).parents[1] / "docs"
PAGE, NUMBERS = DOCS / "reports" / "rivals.md", DOCS / "rivals.json"
SEED = 34
EXAMPLES = Path(__file__).parents[1] / "examples"
CONTENDERS = ("pid", "impedance", "admittance", "hybrid", "following", "drawing", "mpc", "learned")
FILES = {
    "learned": str(EXAMPLES / "learning" / "residual.toml"),
    "mppi": str(EXAMPLES / "sampling" / "mppi.toml"),
}
"""Presets of those that do not ship as one."""
UNSAMPLED = "mppi, unsampled"
"""The same law whose plans are all nothing: what the sampling is worth."""
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
AS_BUILT = VARY | {
    "plant.cog_offset": {"uniform": [-0.01, 0.01], "size": 3},
    "plant.rotor_scale": {"uniform": [0.98, 1.02], "size": 4},
    "plant.thrust_scale": {"uniform": [0.98, 1.02]},
    "sensors.attitude_misalignment": {"uniform": [-0.0175, 0.0175], "size": 3},
}
"""As of one that is not; the ranges of benchmarks/following.py."""
TRIALS, TRIAL_DRAWS = 40, 6
"""Sets of gains that the search flies for each controller, the shipped ones first, and on how many draws."""
_PID = {"proportional": (0.5, 10.0), "integral": (0.01, 3.0), "derivative": (1.0, 12.0)}
_IMPEDANCE = {
    "normalized_stiffness": (0.5, 15.0),
    "damping_ratio": (0.3, 1.5),
    "virtual_mass_ratio": (0.5, 5.0),
}
_FOLLOWING = {"stiffness": (2.0, 60.0), "damping_ratio": (0.3, 1.5)}
SLIDING: dict[str, dict[str, tuple[float, float]]] = {
    **dict.fromkeys(("pid", "admittance"), _PID),
    **dict.fromkeys(("impedance", "hybrid"), _IMPEDANCE),
    **dict.fromkeys(("following", "drawing", "learned"), _FOLLOWING),
    "mpc": {"place_cost": (30.0, 3000.0), "lag": (0.02, 0.2)},
}
"""Gains of both sliding axes that are searched, from and to; of who cancels friction, its share as well."""
CANCELS = ("following", "drawing", "learned", "mpc")


@dataclass(frozen=True)
class Place:
    """What is flown.

    Attributes:
        what: in words.
        experiment: by name; by default the place's own.
        vary: what is drawn.
        contenders: who flies.
        most: draws at most.
        tuned: whether each flies with the gains that a search found for it.
    """

    what: str
    experiment: str = ""
    vary: Mapping[str, Any] = field(default_factory=lambda: VARY)
    contenders: Sequence[str] = CONTENDERS
    most: int = 10**6
    tuned: bool = False


PLACES = {
    "paper": Place("the paper's circle on a leaning board"),
    "paper_as_built": Place("the same by robots that nobody has calibrated", "paper", AS_BUILT),
    "paper_tuned": Place(
        f"the same, each tuned to this line by {TRIALS} sets of its gains on {TRIAL_DRAWS} other draws",
        "paper",
        tuned=True,
    ),
    "cylinder_convex": Place("a circle on a cylinder that bulges"),
    "sine_gentle": Place("a circle on waves"),
    "push_and_slide": Place("pushes along a wall"),
    "calligraphy": Place("a word whose strokes are pressed harder and softer"),
    "writing": Place("letters of some millimetres"),
    "paper_sampled": Place(
        "the paper's circle again, on the first of its draws, as each flight of `mppi` takes minutes",
        "paper",
        contenders=("following", "drawing", "mpc", "mppi", UNSAMPLED),
        most=12,
    ),
}
COLUMNS = (
    ("line, rms mm", "pen_line_rms", 1e3),
    ("force, std N", "contact_force_normal_std", 1.0),
    ("force, rms off the commanded N", "force_error_rms", 1.0),
    ("in touch", "contact_fraction", 1.0),
)


def unsampled(out: Path) -> str:
    """A preset of `mppi` with two samples, both of which move nothing."""
    law, preset = f'law = "{EXAMPLES / "sampling" / "mppi.py"}"', Path(FILES["mppi"]).read_text("utf-8")
    out.mkdir(parents=True, exist_ok=True)
    file = (out / "unsampled.toml").resolve()
    file.write_text(preset.replace('law = "mppi.py"', f"{law}\nsamples = 2.0"), encoding="utf-8")
    return str(file)


def tuned(name: str, out: Path, trials: int = TRIALS, draws: int = TRIAL_DRAWS) -> str:
    """The preset of a controller with gains that a search found for the paper's circle; kept in `out`."""
    gains = {f"translation.{gain}.{axis}": span for gain, span in SLIDING[name].items() for axis in (1, 2)}
    if name in CANCELS:
        gains |= {f"translation.cancel.{axis}": (0.05, 1.0) for axis in (0, 1)}
    given = {
        "experiment": "paper",
        "controllers": [FILES.get(name, name)],
        "draws": draws,
        "seed": SEED + 1,
        "logs": "none",
        "vary": VARY,
        "tune": {"objective": "pen_line_rms", "trials": trials, "held_out": draws, "gains": gains},
    }
    folder = out / "tuned" / name
    outcome = tune(from_mapping(CampaignSpec, given, "ranking"), folder, resume=folder.exists())
    if not outcome.tuned:
        raise SystemExit("stopped; what was flown is kept")
    (name,) = outcome.tuned
    return str((folder / f"{name}.toml").resolve())


def flown(name: str, draws: int, out: Path, contenders: Sequence[str] = ()) -> list[dict[str, Any]]:
    """What a place's campaign says of each controller; of all that it has, or of some."""
    place = PLACES[name]
    contenders = contenders or place.contenders
    files = [unsampled(out) if one == UNSAMPLED else FILES.get(one, one) for one in contenders]
    given = {
        "experiment": place.experiment or name,
        "controllers": [tuned(one, out) for one in contenders] if place.tuned else files,
        "draws": min(draws, place.most),
        "seed": SEED,
        "logs": "none",
        "score": "pen_line_rms",
        "vary": dict(place.vary),
    }
    folder = out / name
    outcome = run_campaign(from_mapping(CampaignSpec, given, "ranking"), folder, resume=folder.exists())
    summary, rows = outcome.summary, list[dict[str, Any]]()
    if summary is None:
        raise SystemExit("stopped; what was flown is kept")
    for index, (controller, flew) in enumerate(zip(contenders, summary.scores.controllers, strict=True)):
        row: dict[str, Any] = {"place": name, "controller": controller, "draws": len(summary.scores.draws)}
        row["lost"] = sum(one["controller"] == flew for one in summary.lost)
        row["fails"] = fails_where(summary, flew, "loss")
        for _, key, _ in COLUMNS:
            row[key] = [float(number) for number in summary.medians[key][index]]
            row[f"{key} rank"] = shown_ranks(summary.ranks.get(key, [0] * len(contenders)))[index]
        rows.append(row)
    return rows


def cost(name: str, more: Mapping[str, Any] = MappingProxyType({})) -> float:
    """What a tick of a flight costs, us: closed loop, physics and all, on one thread.

    Args:
        name: of the controller.
        more: what else is different from the paper's experiment.
    """
    short = {"supervisor.on": False, "phases.hover": 0.5, "phases.tare": 1.0}
    (takeoff,) = take_off("paper", (FILES.get(name, name),), 0, {**short, **more})
    if takeoff.compiled:
        compile_native(takeoff.tick.function)
    times = []
    for _ in range(3 if takeoff.compiled else 1):
        begin = time.perf_counter()
        (flight,) = fly_native([takeoff], 1)
        times.append((time.perf_counter() - begin) / flight.ticks)
    return 1e6 * min(times)


def table(rows: Sequence[dict[str, Any]], costs: dict[str, float]) -> str:
    """Medians with their 95 % intervals, and ranks where the draws tell anybody apart."""
    head = ("controller", "lost", *(title for title, *_ in COLUMNS))
    parts = []
    for name, place in PLACES.items():
        own = [row for row in rows if row["place"] == name]
        if not own:
            continue
        lines = [f"**`{name}`**, {place.what}; {own[0]['draws']} draws each", ""]
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
    parser.add_argument("--costs", action="store_true", help="time the ticks, on a machine that is idle")
    options = parser.parse_args()
    kept = json.loads(NUMBERS.read_text(encoding="utf-8")) if NUMBERS.exists() else {"rows": [], "costs": {}}
    if not options.tables:
        for place in options.only:
            rows = flown(place, options.draws, options.out)
            kept["rows"] = [row for row in kept["rows"] if row["place"] != place] + rows
            NUMBERS.write_text(json.dumps(kept, indent=0), encoding="utf-8")
    if options.costs:
        kept["costs"] = {name: cost(name) for name in (*CONTENDERS, "mppi")}
        NUMBERS.write_text(json.dumps(kept, indent=0), encoding="utf-8")
    fill(PAGE, "ranking", table(kept["rows"], kept["costs"]))
    print(table(kept["rows"], kept["costs"]))


if __name__ == "__main__":
    main()
