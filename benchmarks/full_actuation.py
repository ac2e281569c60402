"""Fully actuated flight: what it reaches, over many draws.

    python benchmarks/full_actuation.py [--draws 100]          (a quarter of an hour; sections of the page)

Pushes: the hovering robot is pushed sideways in a random level direction; how far its body tilts. Tasks:
each with robots that do not know themselves, surfaces that are not where they should be, and sensors that are
late. A task is done when the flight's own verdict says so. Stability: of the linearised loop while the tip
presses. Passivity: of the tip's admittance.
The sections between the markers of docs/reports/full_actuation.md are written anew.
docs/full_actuation.json keeps the verdict and the errors of every task's flight; with --resume those that it
has are not flown again.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

# Matrices of this size are faster on one thread.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from scipy.spatial.transform import Rotation

import skylimb
from skylimb.analysis.recording.run import Run
from skylimb.base.keys import keys_of
from skylimb.control.loop.flight import Flight
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.experiments.tolerances import Tolerances
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import Takeoff, take_off
from skylimb.studies.verification.stability import (
    active_bands,
    at,
    linearise,
    operating_point,
    real_part,
    tip_port,
)

PAGE = Path(__file__).parents[1] / "docs" / "reports" / "full_actuation.md"
KEPT = PAGE.parents[1] / "full_actuation.json"
BATCH = 20
SEED = 8
"""Of the tasks' draws. Controllers were tuned on draws of the seed 7, so nothing was tuned on these."""
PUSHES = (
    ("hydrus_xi_quad", 1.0, "level"),
    ("hydrus_xi_quad", 1.0, "pseudoinverse"),
    ("tiltable_hexarotor", 5.0, "level"),
    ("tiltable_hexarotor", 5.0, "pseudoinverse"),
    ("tilted_hexarotor", 5.0, 'bounded"\nside_force = "rotors'),
    ("hydrus_xi_hex", 1.0, "level"),
    ("dragon", 1.0, "level"),
)
"""Robot, push in N, allocation law."""


def body_axes(flight: Flight) -> np.ndarray:
    """z axis of the root link at every tick, W, (k, 3)."""
    return Rotation.from_quat(flight.signal("configuration")[:, [4, 5, 6, 3]]).as_matrix()[:, :, 2]


def tilt(flight: Flight, before: np.ndarray) -> np.ndarray:
    """Angle between the body's z axis and its mean where `before` holds, degrees, (k,)."""
    z = body_axes(flight)
    mean = z[before].mean(axis=0)
    return np.degrees(np.arccos(np.clip(z @ mean / np.linalg.norm(mean), -1.0, 1.0)))


def before_touch(flight: Flight) -> np.ndarray:
    """Whether a tick is in the second before the first touch: calibrated, and in free flight, (k,)."""
    first = int(np.argmax(flight.signal("contact_duty") > 0.0))
    index = np.arange(flight.ticks)
    return (index >= first - 200) & (index < first)


def flown(
    experiment: str, controller: str | None, draws: list[dict[str, Any]], begin: int = 0
) -> Iterator[tuple[Takeoff, Flight]]:
    """Take-off and flight of each draw, from the draw `begin` on."""
    for first in range(begin, len(draws), BATCH):
        some = draws[first : first + BATCH]
        takeoffs = [take_off(experiment, (controller,), first + k, draw)[0] for k, draw in enumerate(some)]
        yield from zip(takeoffs, fly_native(takeoffs), strict=True)


# ---- pushes ----


def pushes(count: int) -> str:
    """A table of the body's tilt under a push at the centre of gravity that begins at once."""
    rows = [
        "| robot | push | allocation | body tilt: median | 95 % | greatest | lost |",
        "|---|---|---|---|---|---|---|",
    ]
    for robot, force, law in PUSHES:
        angles, lost = [], 0
        with tempfile.TemporaryDirectory() as folder:
            path = preset_with(law, Path(folder))
            for _, flight in flown("push", path, push_draws(robot, force, count)):
                lost += bool(flight.cause)
                time = np.arange(flight.ticks) * 0.005
                angles.append(tilt(flight, (time > 1.0) & (time < 2.0))[time > 2.0].max())
        name = law.partition('"')[0]
        low, high, most = np.median(angles), np.quantile(angles, 0.95), np.max(angles)
        rows.append(
            f"| `{robot}` | {force:g} N | `{name}` | {low:.2f}° | {high:.2f}° | {most:.2f}° | {lost} |"
        )
    return "\n".join(rows)


def push_draws(robot: str, force: float, count: int) -> list[dict[str, Any]]:
    """Pushes in random level directions."""
    angles = np.random.default_rng(1).uniform(-np.pi, np.pi, count)
    return [
        {
            "robot": robot,
            "events.0.force": [force * np.cos(angle), force * np.sin(angle), 0.0],
            "events.0.time": 2.0,
            "events.0.duration": 6.0,
            "phases.hover": 0.5,
            "phases.tare": 1.0,
            "phases.hover_end": 0.0,
            "trajectory.duration": 6.0,
        }
        for angle in angles
    ]


def preset_with(law: str, folder: Path) -> str:
    """The paper's impedance without its feedback of the force, with an allocation law, as a file."""
    shipped = Path(skylimb.__file__).parent / "control" / "presets" / "impedance.toml"
    text = shipped.read_text(encoding="utf-8").replace("[1.0, 3.0, 1.0]", "[1.0, 1.0, 1.0]")
    path = folder / "pushed.toml"
    path.write_text(text.replace('law = "pseudoinverse"', f'law = "{law}"'), encoding="utf-8")
    return str(path)


# ---- tasks ----


@dataclass(frozen=True)
class Task:
    """A task that is flown many times.

    Attributes:
        name: in the table.
        experiment: that ships.
        wanted: keys that it is flown with.
        draw: further keys of one draw.
        besides: what is measured of a flight besides the scores that its verdict judges.
        controller: a preset; none for the experiment's own.
    """

    name: str
    experiment: str
    wanted: dict[str, Any]
    draw: Callable[[np.random.Generator], dict[str, Any]]
    besides: Callable[[Run, Takeoff, Flight], dict[str, float]]
    controller: str | None = "task_frame"


QUICK = {"phases.hover": 1.0, "phases.tare": 2.0, "phases.hover_end": 0.0}


def unknowns(rng: np.random.Generator) -> dict[str, Any]:
    """What a robot does not know of itself: thrusts, mass, attitude, latency."""
    return {
        "plant.thrust_scale": rng.uniform(0.98, 1.02),
        "plant.rotor_scale": rng.uniform(0.98, 1.02, 4).tolist(),
        "plant.mass_scale": rng.uniform(0.99, 1.01),
        "sensors.attitude_misalignment": [*np.radians(rng.uniform(-1.0, 1.0, 2)).tolist(), 0.0],
        "sensors.latency": rng.uniform(0.01, 0.03),
    }


def elsewhere(rng: np.random.Generator, *most: float) -> dict[str, Any]:
    """A surface that is not where the robot believes it to be: by up to so much along each axis, W, m."""
    return {"surface_error": [rng.uniform(-one, one) for one in most]}


def leaning(rng: np.random.Generator, most: float) -> dict[str, Any]:
    """A surface that leans both ways, by up to so many degrees."""
    return {f"surface.{angle}": np.radians(rng.uniform(-most, most)) for angle in ("slope", "pitch")}


def plane_draw(rng: np.random.Generator) -> dict[str, Any]:
    """A plane that leans by up to 5 degrees otherwise than it should, and stands up to 2 cm elsewhere."""
    return {
        **unknowns(rng),
        **elsewhere(rng, 0.02, 0.02, 0.02),
        **leaning(rng, 5.0),
        "surface.friction": rng.uniform(0.5, 0.8),
    }


FORCE = np.array([2.0, 0.5, -0.4])


def plane_besides(run: Run, takeoff: Takeoff, flight: Flight) -> dict[str, float]:
    """The mean force of the last ten seconds of contact against the wanted one, and the body's tilt there."""
    end = sliding(takeoff, flight)[-2000:]
    frame = takeoff.mission.frame
    axes = np.stack([frame.contact, frame.sliding_u, frame.sliding_v])
    force = -axes @ flight.signal("contact_force")[end].mean(axis=0)
    leaning = float(np.median(tilt(flight, before_touch(flight))[end]))
    return {"force vector, N": float(np.linalg.norm(force - FORCE)), "body tilt, °": leaning}


def pipe_draw(rng: np.random.Generator) -> dict[str, Any]:
    """A pipe up to 1 cm thicker or thinner than the path, up to 1 cm elsewhere, with unknown friction."""
    return {
        **unknowns(rng),
        **elsewhere(rng, 0.01, 0.01, 0.0),
        "surface.radius": rng.uniform(0.29, 0.31),
        "surface.friction": rng.uniform(0.1, 0.4),
    }


def pipe_besides(run: Run, takeoff: Takeoff, flight: Flight) -> dict[str, float]:
    """The body's tilt all the way around."""
    leaning = _tilt_of_turning(flight)[sliding(takeoff, flight)]
    return {"body tilt, °": float(np.quantile(leaning, 0.95))}


def _tilt_of_turning(flight: Flight) -> np.ndarray:
    """Tilt of a body that turns about the vertical, against its mean before the touch, degrees, (k,)."""
    R = Rotation.from_quat(flight.signal("configuration")[:, [4, 5, 6, 3]])
    down = R.inv().apply([0.0, 0.0, 1.0])
    mean = down[before_touch(flight)].mean(axis=0)
    return np.degrees(np.arccos(np.clip(down @ mean / np.linalg.norm(mean), -1.0, 1.0)))


def face_draw(rng: np.random.Generator) -> dict[str, Any]:
    """A plane that leans by up to 6 degrees both ways and stands up to 2 cm elsewhere."""
    return {
        **unknowns(rng),
        **elsewhere(rng, 0.02, 0.02, 0.02),
        **leaning(rng, 6.0),
        "surface.friction": rng.uniform(0.3, 0.8),
    }


TORQUE = np.array([0.1, -0.05])


def face_besides(run: Run, takeoff: Takeoff, flight: Flight) -> dict[str, float]:
    """The torque at the tip over the last five seconds of contact against the wanted one."""
    end = sliding(takeoff, flight)[-1000:]
    force = flight.signal("contact_force")[end]
    touching = np.linalg.norm(force, axis=1) > 0.1
    lever = flight.signal("contact_point")[end] - run.log.tip_position.values[end]
    torque = np.cross(lever[touching], force[touching]).mean(axis=0)
    return {"torque, N m": float(np.linalg.norm(-torque[1:] - TORQUE))}


def valve_draw(rng: np.random.Generator) -> dict[str, Any]:
    """A valve up to 1 cm off in each direction, that leans by up to 3 degrees and turns harder or easier."""
    return {
        **unknowns(rng),
        **elsewhere(rng, 0.01, 0.01, 0.01),
        **leaning(rng, 3.0),
        "surface.lever_angle": np.radians(rng.uniform(-5.0, 5.0)),
        "surface.friction": rng.uniform(0.1, 0.5),
        "surface.friction_torque": rng.uniform(0.2, 0.4),
    }


def valve_besides(run: Run, takeoff: Takeoff, flight: Flight) -> dict[str, float]:
    """The push on its lever, and the body's tilt."""
    pushing = sliding(takeoff, flight)
    push = float(np.quantile(np.linalg.norm(flight.signal("contact_force")[pushing], axis=1), 0.99))
    leaning = float(np.quantile(tilt(flight, before_touch(flight))[pushing], 0.95))
    return {"push, N": push, "body tilt, °": leaning}


def peg_draw(rng: np.random.Generator) -> dict[str, Any]:
    """A hole up to 8 mm beside its place and 1 cm before or behind it, that leans by up to 3 degrees."""
    return {
        **unknowns(rng),
        **elsewhere(rng, 0.01, 0.008, 0.008),
        **leaning(rng, 3.0),
        "surface.friction": rng.uniform(0.1, 0.3),
    }


def peg_besides(run: Run, takeoff: Takeoff, flight: Flight) -> dict[str, float]:
    """The body's tilt over the last five seconds in the hole."""
    end = sliding(takeoff, flight)[-1000:]
    return {"body tilt, °": float(np.median(tilt(flight, before_touch(flight))[end]))}


def ceiling_draw(rng: np.random.Generator) -> dict[str, Any]:
    """A ceiling that leans by up to 5 degrees both ways and is up to 2 cm elsewhere; friction is unknown."""
    return {
        **unknowns(rng),
        **elsewhere(rng, 0.02, 0.02, 0.02),
        **leaning(rng, 5.0),
        "surface.friction": rng.uniform(0.1, 0.5),
    }


def sliding(takeoff: Takeoff, flight: Flight) -> np.ndarray:
    """The ticks of the sliding period, (k,)."""
    return np.flatnonzero(takeoff.mission.in_phase("slide")[: flight.ticks])


TASKS = (
    Task(
        "a foot of 16 cm pushes flat on a plane of unknown lean with 3 N and torques of 0.1 and -0.05 N m",
        "face_to_face",
        QUICK,
        face_draw,
        face_besides,
        None,
    ),
    Task(
        "push with 2.1 N in three directions at a plane that leans by 20°",
        "tilted_push",
        {
            **QUICK,
            "controller.contact.force": FORCE.tolist(),
            "controller.contact.stiffness": [0.0, 0.0, 0.0],
            "controller.contact.damping": [30.0, 60.0, 60.0],
        },
        plane_draw,
        plane_besides,
    ),
    Task(
        "once around an upright pipe of 0.3 m radius with 1 N",
        "pipe_around",
        QUICK,
        pipe_draw,
        pipe_besides,
    ),
    Task(
        "a valve with 0.2 to 0.4 N m of dry friction is turned by 90° to its stop",
        "valve",
        QUICK,
        valve_draw,
        valve_besides,
        None,
    ),
    Task(
        "a peg of 30 mm goes 6 cm into a hole of 34 mm with a chamfer of 2 cm, to its floor, and out again",
        "peg",
        {**QUICK, "phases.hover_end": 2.0},
        peg_draw,
        peg_besides,
        None,
    ),
    Task(
        "a circle of 0.3 m radius on a ceiling with 1 N, the pen on a mast",
        "ceiling",
        {},
        ceiling_draw,
        lambda run, takeoff, flight: {},
        None,
    ),
)


def tasks(count: int, only: list[str], resume: bool) -> str:
    """A table of the tasks, and what was not done by name; what is not flown stays as it was kept."""
    kept: dict[str, list[dict[str, Any]]] = (
        json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}
    )
    for task in TASKS:
        if only and task.experiment not in only:
            continue
        flights = kept.get(task.experiment, [])[:count] if resume else []
        rng = np.random.default_rng(SEED)
        draws = [{**task.wanted, **task.draw(rng)} for _ in range(count)]
        for takeoff, flight in flown(task.experiment, task.controller, draws, len(flights)):
            run = scored_run(takeoff, flight)
            judged = {name: check["value"] for name, check in run.metrics["checks"].items()}
            besides = {} if run.failed else task.besides(run, takeoff, flight)
            flights.append({"done": run.done, "missed": run.missed, "judged": judged, "besides": besides})
            if len(flights) % BATCH == 0 or len(flights) == count:
                kept[task.experiment] = flights
                aside = KEPT.with_suffix(".aside")
                aside.write_text(json.dumps(kept, indent=0) + "\n", encoding="utf-8")
                aside.replace(KEPT)
    shown = [task for task in TASKS if task.experiment in kept]
    return "\n".join((*_HEAD, *(row(task, kept[task.experiment]) for task in shown))) + misses(kept)


_HEAD = (
    "| task | experiment | done | lost | judged: median, 95 % (tolerance) | besides: median, 95 % |",
    "|---|---|---|---|---|---|",
)

_SHOWN = {"": (100.0, " %"), "m": (1e3, " mm"), "rad": (180.0 / np.pi, "°")}
"""How a tolerance of some unit is shown."""


def row(task: Task, flights: list[dict[str, Any]]) -> str:
    """A task's line of the table."""
    finished = [flight for flight in flights if flight["judged"]]
    tolerances = skylimb.load_experiment(task.experiment).tolerances
    judged = []
    for name in finished[0]["judged"] if finished else ():
        scale, unit = _SHOWN[keys_of(Tolerances)[name].unit]
        said = spread([scale * flight["judged"][name] for flight in finished])
        judged.append(f"{name} {said}{unit} ({scale * getattr(tolerances, name):.3g}{unit})")
    besides = [
        f"{name} {spread([flight['besides'][name] for flight in finished])}"
        for name in (finished[0]["besides"] if finished else ())
    ]
    done, lost = sum(bool(flight["done"]) for flight in flights), len(flights) - len(finished)
    cells = (
        task.name,
        f"`{task.experiment}`",
        f"{done} of {len(flights)}",
        lost,
        "; ".join(judged),
        "; ".join(besides),
    )
    return f"| {' | '.join(map(str, cells))} |"


def spread(values: list[float]) -> str:
    """Median and 95 % of some values."""
    return f"{np.median(values):.3g}, {np.quantile(values, 0.95):.3g}"


def misses(kept: dict[str, list[dict[str, Any]]]) -> str:
    """Each flight that was not done, with what it missed."""
    lines = [
        f"- `{name}`, draw {index}: {'; '.join(flight['missed'])}"
        for name, flights in kept.items()
        for index, flight in enumerate(flights)
        if not flight["done"]
    ]
    return "\n\nNot done:\n\n" + "\n".join(lines) if lines else "\n\nEvery flight was done."


# ---- stability ----

REST = {
    "phases.hover": 1.0,
    "phases.tare": 1.0,
    "sensors.latency": 0.02,
    "surface.slope": 0.0,
    "surface.friction": 0.0,
    "trajectory.shape": "hold",
}
AXES: tuple[tuple[str, str, tuple[float, ...]], ...] = (
    ("stiffness of the surface, N/m", "stiffness", (300.0, 1e3, 5e3, 2e4, 5e4)),
    ("latency, 20 ms assumed, s", "latency", (0.0, 0.02, 0.04, 0.06, 0.08)),
    ("damper of the admittance, times", "x contact.damping", (0.03, 0.1, 0.3, 1.0, 3.0)),
    ("stiffness of the position, times", "x translation.stiffness", (0.3, 0.6, 1.0, 1.5, 2.0)),
    ("stiffness of the attitude, times", "x attitude.stiffness", (0.3, 0.6, 1.0, 1.5, 2.0)),
    ("lead of the vectoring angles", "allocation.vectoring.lead", (1.0, 1.5, 2.0, 2.5, 3.0)),
)


def stability() -> str:
    """Growth of the dominant mode while the tip presses, over one parameter at a time."""
    controller: Any = skylimb.load_controller("task_frame", skylimb.load_robot("hydrus_xi_quad"))
    point = operating_point(skylimb.load_experiment("paper", REST), controller)
    rows = ["| parameter | | | | | |", "|---|---|---|---|---|---|"]
    for name, axis, values in AXES:
        growths = [linearise(at(point, axis, value)).growth for value in values]
        cells = [f"{value:g}: {growth:.2f}" for value, growth in zip(values, growths, strict=True)]
        cells = [f"**{cell}**" if growth > 0.0 else cell for cell, growth in zip(cells, growths, strict=True)]
        rows.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(rows)


PORTS = ("impedance", "admittance", "hybrid", "task_frame")
FREQUENCIES = np.geomspace(0.05, 95.0, 160)
SPRINGS = np.geomspace(3.0, 1e5, 28)
DAMPERS = np.array([0.0, *np.round(np.geomspace(1.0, 1000.0, 25), 1)])


def passivity() -> str:
    """Where the tip's admittance is not passive, which springs make it grow, and what calms it, each axis."""
    rows = [
        "| preset | axis | not passive, Hz | least real part, mm/s per N | springs that make it grow, N/m "
        "| damper that calms all of them, N s/m |",
        "|---|---|---|---|---|---|",
    ]
    for name in PORTS:
        controller: Any = skylimb.load_controller(name, skylimb.load_robot("hydrus_xi_quad"))
        port = tip_port(operating_point(skylimb.load_experiment("paper", REST), controller), np.eye(3))
        Y = port.admittance(FREQUENCIES)
        for i, axis in enumerate(("contact axis", "u, sideways", "v, up")):
            one = Y[:, i : i + 1, i : i + 1]
            least = real_part(one)
            where = int(np.argmin(least))
            bands = ", ".join(f"{low:.2g} to {high:.2g}" for low, high in active_bands(FREQUENCIES, one))
            worst = f"{1e3 * least[where]:.2g} at {FREQUENCIES[where]:.2g} Hz" if bands else "none below 0"
            tip = port.along(np.eye(3)[i])
            springs, damper = tip.unstable_springs(SPRINGS), tip.calming_damper(SPRINGS, DAMPERS)
            said = "none" if springs is None else f"{springs[0]:.0f} to {springs[1]:.0f}"
            calm = "none" if damper is None else f"{damper:g}"
            rows.append(f"| `{name}` | {axis} | {bands or 'none'} | {worst} | {said} | {calm} |")
    return "\n".join(rows)


def write(name: str, text: str) -> None:
    """Write a section between its markers in the page."""
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    page = PAGE.read_text(encoding="utf-8")
    pattern = re.compile(f"{re.escape(begin)}.*?{re.escape(end)}", re.DOTALL)
    if not pattern.search(page):
        raise SystemExit(f"{PAGE.name} has no section '{name}'")
    PAGE.write_text(pattern.sub(lambda _: f"{begin}\n\n{text}\n\n{end}", page), encoding="utf-8")
    print(text)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument("--part", choices=("pushes", "tasks", "stability", "passivity"), action="append")
    names = [task.experiment for task in TASKS]
    parser.add_argument(
        "--task", choices=names, action="append", default=[], help="of --part tasks: only this"
    )
    parser.add_argument("--resume", action="store_true", help=f"of --part tasks: go on with {KEPT.name}")
    given = parser.parse_args()
    parts: dict[str, Callable[[], str]] = {
        "pushes": lambda: pushes(given.draws),
        "tasks": lambda: tasks(given.draws, given.task, given.resume),
        "stability": stability,
        "passivity": passivity,
    }
    for name in given.part or parts:
        write(name, parts[name]())


if __name__ == "__main__":
    main()
