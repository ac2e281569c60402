"""Where contact is hard: weak rotors, late sensors, sheets, steps, boards that sway or vanish, tiny drawings.

    python benchmarks/hard_contact.py [--draws 50] [--only TEXT] [--minutes 60] [--tables]

Each place is flown by `following` and `drawing`, by robots that do not know themselves: the draws of
benchmarks/following.py (friction 0.1 .. 0.8, thrust, attitude, mass, centre of gravity, latency, noise), with
another seed and with what the place says put over them. Drawings are flown by a robot that knows itself.
Where the supervisor has a part in it (weak rotors, late sensors, pushes, a board that vanishes) it flies
along, with `supervisor.losses`. docs/hard_contact.json keeps every flight, a line each; one that it holds is
not flown again. The table of docs/reports/hard_contact.md is written anew.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from following import draws  # the same draws, beside this file
from kept import fill, keep

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.registry import measured
from skylimb.base.errors import SkylimbError
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import take_off

HERE = Path(__file__).parent
DOCS = HERE.parent / "docs"
PAGE, NUMBERS = DOCS / "reports" / "hard_contact.md", DOCS / "hard_contact.json"
PRESETS = ("following", "drawing")
SEED = 2026  # no gain was chosen on it
EVENT = 20.0  # s; the pen slides since some five seconds
BACK = float(np.radians(-20.0))
NOISE = ("position", "velocity", "attitude", "angular_velocity", "joint", "vectoring")

Changes = Mapping[str, Any]
Score = tuple[str, float, float | None, float]
"""Title with its unit, scale, and what median (None: not said) and worst decile are held to."""


@dataclass(frozen=True)
class Place:
    """A place, and what is wanted there: score -> title, scale, bounds of median and worst decile."""

    name: str
    wanted: Mapping[str, Score]
    changes: Changes = field(default_factory=dict)
    experiment: str = "paper"
    presets: tuple[str, ...] = PRESETS
    known: bool = False
    supervised: bool = False


TOUCH: Score = ("in touch", 1.0, None, 0.95)
LINE: Score = ("line, rms mm", 1e3, None, 12.0)


def _event(kind: str, **keys: Any) -> dict[str, Any]:
    return {"events": [{"kind": kind, "time": EVENT, **keys}]}


def _push(force: Sequence[float]) -> dict[str, Any]:
    return _event("push", duration=1.0, force=list(force))


def _drawing(**keys: Any) -> dict[str, Any]:
    pen = {"shape": "drawing", "speed": 0.05, "acceleration": 0.05, "feedforward": "full"}
    return {f"trajectory.{key}": value for key, value in (pen | keys).items()}


def _file(name: str, width: float) -> dict[str, Any]:
    return _drawing(file=str(HERE / "drawings" / name), width=width)


FLAT: Changes = {"surface.slope": 0.0}
SUPERVISED: Changes = {"supervisor.on": True, "supervisor.losses": True}
WEAK: Mapping[str, Score] = {
    "sag": ("hover off, m", 1.0, None, 0.1),
    "force_error_percent": ("mean force off, %", 1.0, 3.0, 3.0),
}
LATE: Mapping[str, Score] = {"pen_line_rms": LINE, "contact_fraction": TOUCH}
FINE: Mapping[str, Score] = {
    "pen_line_rms": ("line, rms mm", 1e3, 1.0, 1.0),
    "line_covered": ("covered", 1.0, None, 0.95),
}
PLACES = (
    Place("as it is", LATE),
    *(
        Place(f"thrust {100 * (scale - 1):+.0f} %", WEAK, {"plant.thrust_scale": scale}, supervised=True)
        for scale in (0.92, 0.88, 0.8, 1.2)
    ),
    *(
        Place(f"latency {1000 * late:.0f} ms, 20 believed", LATE, {"sensors.latency": late}, supervised=True)
        for late in (0.045, 0.06)
    ),
    *(
        Place(f"rotor lag {1000 * lag:.0f} ms, 50 believed", LATE, {"plant.rotor_lag": lag}, supervised=True)
        for lag in (0.1, 0.12)
    ),
    *(
        Place(
            name,
            {
                "contact_fraction": ("in touch", 1.0, None, touch),
                "force_slow_std": ("force std, N", 1.0, None, 0.3),
            },
            changes,
            experiment,
        )
        for name, touch, changes, experiment in (
            ("corrugated sheet", 0.97, FLAT | {"surface.kind": "corrugated"}, "paper"),
            ("ridge", 0.95, FLAT | {"surface.kind": "ridge"}, "paper"),
            ("step of 10 mm", 0.95, {}, "step_10mm"),
        )
    ),
    Place(
        "swaying board, 20 mm at 0.25 Hz",
        {"pen_line_rms": ("line, rms mm", 1e3, 9.0, 14.0)},
        {"surface.sway_amplitude": 0.02, "surface.sway_frequency": 0.25},
    ),
    Place(
        "hard surface, noise x 3",
        {"touch_force_peak": ("first touch, N", 1.0, 3.0, 4.0)},
        {"surface.stiffness": 20000.0, "noise": 3.0},
    ),
    Place(
        "ceiling, friction 0.7",
        {
            "contact_force_normal_mean": ("force, N", 1.0, 0.95, 0.95),
            "contact_fraction": ("in touch", 1.0, 0.97, 0.97),
            "contact_losses": ("losses of contact", 1.0, 2.0, 2.0),
        },
        {"surface.friction": 0.7},
        "ceiling",
    ),
    *(
        Place(
            f"friction 0.8 at -20 degrees, {force:g} N",
            {
                "force_slow_std": ("force std, N", 1.0, 0.3, 0.3),
                "contact_fraction": ("in touch", 1.0, 0.97, 0.97),
            },
            {"surface.friction": 0.8, "surface.slope": BACK, "controller.translation.force": force},
        )
        for force in (1.0, 0.5)
    ),
    Place(
        "friction jumps from 0.2 to 1.2",
        {
            "contact_losses": ("losses of contact", 1.0, 3.0, 3.0),
            "contact_force_normal_peak": ("peak force, N", 1.0, 5.0, 5.0),
        },
        {"surface.friction": 0.2} | _event("surface", duration=0.0, friction=1.2),
    ),
    *(
        Place(
            f"circle of {1000 * size:.0f} mm",
            FINE,
            _file("circle.svg", size),
            presets=("drawing",),
            known=True,
        )
        for size in (0.01, 0.015, 0.025)
    ),
    Place("star of 80 mm", FINE, _file("star.svg", 0.08), presets=("drawing",), known=True),
    Place(
        "i-dots, letters of 40 mm",
        FINE,
        _drawing(text="iii", height=0.04, width=0.0),
        presets=("drawing",),
        known=True,
    ),
    Place(
        "dashed line of 12 strokes",
        {"flight_time": ("time, s", 1.0, 100.0, 100.0), "pen_line_rms": ("line, rms mm", 1e3, 1.0, 1.5)},
        _file("dashes.svg", 0.6),
        presets=("drawing",),
        known=True,
    ),
    *(
        Place(f"push of 8 N, {side}", {"contact_fraction": TOUCH}, _push(force), supervised=True)
        for side, force in (("to +y", (0.0, 8.0, 0.0)), ("to -y", (0.0, -8.0, 0.0)))
    ),
    *(
        Place(
            f"board gone, {force:g} N",
            {"caught": ("tip on, mm", 1e3, middle, worst)},
            {"controller.translation.force": force} | _event("surface", present=False),
            supervised=True,
        )
        for force, middle, worst in ((1.0, 60.0, 60.0), (2.0, 90.0, 90.0))
    ),
    *(
        Place(
            f"{force:g} N, slope 0, friction up to 0.4",
            {"force_error_percent": ("mean force off, %", 1.0, 5.0, 5.0)},
            {"surface.slope": 0.0, "most friction": 0.4, "controller.translation.force": force},
        )
        for force in (4.0, 5.0)
    ),
)
MORE_IS_BETTER = ("contact_fraction", "line_covered", "contact_force_normal_mean")


def changed(place: Place, drawn: Changes) -> dict[str, Any]:
    """What a draw at a place changes in its experiment."""
    given: dict[str, Any] = {"seed": drawn["seed"]} if place.known else dict(drawn)
    given |= {**place.changes, **(SUPERVISED if place.supervised else {})}
    if most := given.pop("most friction", 0.0):
        given["surface.friction"] = most * (drawn["surface.friction"] - 0.1) / 0.7
    if factor := given.pop("noise", 0.0):
        (plain,) = take_off(place.experiment, PRESETS[:1])
        sensors = plain.experiment.sensors
        given |= {f"sensors.{kind}_noise": factor * getattr(sensors, f"{kind}_noise") for kind in NOISE}
    if given.get("trajectory.shape") == "drawing":
        given.pop("trajectory.direction", None)
    return given


def sag(run: Run) -> float:
    """How far the centre of gravity is from its height before the first touch, at most, m."""
    log = run.log
    hovering = np.cumsum(log.contact.values > 0) == 0
    off = (log.cog_position - log.cog_position_reference).sel(axis="z").values[hovering]
    return float(np.abs(off).max())


def caught(run: Run) -> float:
    """How far the tip is along the contact axis within 3 s after the event, at most, m."""
    time_, x = run.log.time.values, run.log.tip_position.sel(axis="x").values
    after = x[(time_ >= EVENT) & (time_ < EVENT + 3.0)]
    return float(after.max() - after[0])


OWN: Mapping[str, Callable[[Run], float]] = {"sag": sag, "caught": caught}


def fly(place: Place, preset: str, drawn: Changes) -> dict[str, Any]:
    """The scores of one flight, or why there are none."""
    try:
        (takeoff,) = take_off(place.experiment, (preset,), None, changed(place, drawn))
        run = scored_run(takeoff, fly_native([takeoff])[0])
    except SkylimbError as error:
        return {"refused": str(error)}
    found = {**run.metrics, **measured(run, ["contact", "faults"])}
    if run.failed:
        ended = "landed" if found["fault_landed"] else "lost" if run.lost else "not finished"
        return {ended: run.cause}
    return {key: OWN[key](run) if key in OWN else found[key] for key in place.wanted}


def cells(place: Place, rows: Sequence[Changes]) -> Iterator[str]:
    """Each wanted score: median / worst decile, and what they are held to."""
    for key, (title, scale, *bounds) in place.wanted.items():
        values = [scale * row[key] for row in rows if row.get(key) is not None]
        more = key in MORE_IS_BETTER
        found = np.percentile(values, [50, 10 if more else 90]) if values else []
        good = bool(values) and all(
            bound is None or (value >= bound if more else value <= bound)
            for value, bound in zip(found, bounds, strict=True)
        )
        wanted = " / ".join("-" if bound is None else f"{bound:g}" for bound in bounds)
        shown = " / ".join(f"{value:.3g}" for value in found) or "-"
        yield f"{title}: {'**' if good else ''}{shown}{'**' if good else ''} ({wanted})"


def table(rows: Sequence[Changes]) -> str:
    """A line for each place and preset."""
    ends = ("refused", "landed", "not finished", "lost")
    lines = [
        f"| where | preset | draws | {' | '.join(ends)} | median / worst decile (wanted) |",
        "|---" * 8 + "|",
    ]
    for place in PLACES:
        for preset in place.presets:
            own = [row for row in rows if (row["place"], row["preset"]) == (place.name, preset)]
            if own:
                head = (
                    place.name,
                    f"`{preset}`",
                    *(str(sum(key in row for row in own)) for key in ("draw", *ends)),
                )
                lines.append("| " + " | ".join([*head, "; ".join(cells(place, own))]) + " |")
    return "\n".join(lines)


def main() -> None:
    """Fly what is missing, keep it, write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--draws", type=int, default=50)
    parser.add_argument("--only", default="", help="places with this text in their name, flown anew")
    parser.add_argument("--minutes", type=float, default=60.0, help="begin no more flights after so long")
    parser.add_argument(
        "--tables", action="store_true", help="fly nothing: the table of docs/hard_contact.json"
    )
    options = parser.parse_args()
    rows: list[dict[str, Any]] = json.loads(NUMBERS.read_text(encoding="utf-8")) if NUMBERS.exists() else []
    if options.only:
        rows = [row for row in rows if options.only not in row["place"]]
    known, began = {(row["place"], row["preset"], row["draw"]) for row in rows}, time.monotonic()
    todo = [
        (number, drawn, place, preset)
        for number, drawn in enumerate(draws("paper", options.draws, SEED))
        for place in PLACES
        for preset in place.presets
        if not options.tables and options.only in place.name
        if (place.name, preset, number) not in known
    ]
    for number, drawn, place, preset in todo:
        if time.monotonic() - began > 60.0 * options.minutes:
            break
        rows.append({"place": place.name, "preset": preset, "draw": number} | fly(place, preset, drawn))
        keep(NUMBERS, rows)
        print(len(rows), rows[-1], flush=True)
    fill(PAGE, "places", table(rows))
    print(table(rows))


if __name__ == "__main__":
    main()
