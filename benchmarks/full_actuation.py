"""Fully actuated flight: what it reaches, over many draws.

    python benchmarks/full_actuation.py [--draws 100]          (four minutes; sections of the page)

Pushes: the hovering robot is pushed sideways in a random level direction; how far its body tilts. Tasks:
each with robots that do not know themselves, surfaces that are not where they should be, and sensors that are
late. A task counts as done when its tolerance holds. Stability: of the linearised loop while the tip presses.
Passivity: of the tip's admittance.
The sections between the markers of docs/full_actuation.md are written anew.
"""

from __future__ import annotations

import argparse
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
from skylimb.flights.drivers.native import fly_native
from skylimb.flights.loading import take_off
from skylimb.loop.flight import Flight
from skylimb.verification.stability import (
    active_bands,
    at,
    linearise,
    operating_point,
    real_part,
    tip_port,
)

PAGE = Path(__file__).parents[1] / "docs" / "full_actuation.md"
BATCH = 20
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
    experiment: str, controller: str | None, draws: list[dict[str, Any]]
) -> Iterator[tuple[dict[str, Any], Any, Flight]]:
    """Each draw with its mission and its flight."""
    for first in range(0, len(draws), BATCH):
        some = draws[first : first + BATCH]
        takeoffs = [take_off(experiment, (controller,), first + k, draw)[0] for k, draw in enumerate(some)]
        for draw, takeoff, flight in zip(some, takeoffs, fly_native(takeoffs), strict=True):
            yield draw, takeoff.mission, flight


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
            for _, _, flight in flown("push", path, push_draws(robot, force, count)):
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
            "disturbance.force": [force * np.cos(angle), force * np.sin(angle), 0.0],
            "disturbance.start": 2.0,
            "disturbance.duration": 6.0,
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
        tolerance: in words.
        draw: further keys of one draw.
        score: errors of a flight, and whether they are within the tolerance.
        controller: a preset; none for the experiment's own.
    """

    name: str
    experiment: str
    wanted: dict[str, Any]
    tolerance: str
    draw: Callable[[np.random.Generator], dict[str, Any]]
    score: Callable[[dict[str, Any], Any, Flight], tuple[dict[str, float], bool]]
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


def plane_draw(rng: np.random.Generator) -> dict[str, Any]:
    """A plane that leans by up to 5 degrees otherwise than it should, and stands up to 2 cm elsewhere."""
    away = rng.uniform(-0.02, 0.02)
    return {
        **unknowns(rng),
        "surface.position": [1.5 + away, 0.0, 1.2],
        "surface.slope": np.radians(rng.uniform(-5.0, 5.0)),
        "surface.pitch": np.radians(rng.uniform(-5.0, 5.0)),
        "surface.friction": rng.uniform(0.5, 0.8),
    }


FORCE = np.array([2.0, 0.5, -0.4])


def plane_score(draw: dict[str, Any], mission: Any, flight: Flight) -> tuple[dict[str, float], bool]:
    """The mean force of the last ten seconds of contact against the wanted one, and the body's tilt there."""
    end = np.flatnonzero(mission.in_phase("slide")[: flight.ticks])[-2000:]
    axes = np.stack([mission.frame.contact, mission.frame.sliding_u, mission.frame.sliding_v])
    force = -axes @ flight.signal("contact_force")[end].mean(axis=0)
    off = float(np.linalg.norm(force - FORCE))
    leaning = float(np.median(tilt(flight, before_touch(flight))[end]))
    return {"force error, N": off, "body tilt, °": leaning}, off < 0.2 and leaning < 0.5


def pipe_draw(rng: np.random.Generator) -> dict[str, Any]:
    """A pipe up to 1 cm thicker or thinner than the path, up to 1 cm elsewhere, with unknown friction."""
    return {
        **unknowns(rng),
        "surface.radius": rng.uniform(0.29, 0.31),
        "surface.position": [1.5 + rng.uniform(-0.01, 0.01), rng.uniform(-0.01, 0.01), 1.2],
        "surface.friction": rng.uniform(0.1, 0.4),
    }


def pipe_score(draw: dict[str, Any], mission: Any, flight: Flight) -> tuple[dict[str, float], bool]:
    """Touch, force and height all the way around, and the body's tilt."""
    slide = np.flatnonzero(mission.in_phase("slide")[: flight.ticks])
    force = np.linalg.norm(flight.signal("contact_force")[slide], axis=1)
    touch = float(flight.signal("contact_duty")[slide].mean())
    axis = mission.reference.contact_axis[slide]
    normal = float(-np.sum(flight.signal("contact_force")[slide] * axis, axis=1).mean())
    points = flight.signal("contact_point")[slide][force > 0.1]
    height = float(np.quantile(np.abs(points[:, 2] - 1.2), 0.95))
    leaning = float(np.quantile(_tilt_of_turning(flight)[slide], 0.95))
    good = touch > 0.95 and abs(normal - 1.0) < 0.1 and height < 0.03 and leaning < 1.0
    return {"touch, %": 100.0 * touch, "force, N": normal, "height error, mm": 1e3 * height,
            "body tilt, °": leaning}, good  # fmt: skip


def _tilt_of_turning(flight: Flight) -> np.ndarray:
    """Tilt of a body that turns about the vertical, against its mean before the touch, degrees, (k,)."""
    R = Rotation.from_quat(flight.signal("configuration")[:, [4, 5, 6, 3]])
    down = R.inv().apply([0.0, 0.0, 1.0])
    mean = down[before_touch(flight)].mean(axis=0)
    return np.degrees(np.arccos(np.clip(down @ mean / np.linalg.norm(mean), -1.0, 1.0)))


def face_draw(rng: np.random.Generator) -> dict[str, Any]:
    """A plane that leans by up to 6 degrees both ways, which the controller does not know."""
    return {
        **unknowns(rng),
        "surface.position": [1.5 + rng.uniform(-0.02, 0.02), 0.0, 1.2],
        "surface.slope": np.radians(rng.uniform(-6.0, 6.0)),
        "surface.pitch": np.radians(rng.uniform(-6.0, 6.0)),
        "surface.friction": rng.uniform(0.3, 0.8),
    }


TORQUE = np.array([0.1, -0.05])


def face_score(draw: dict[str, Any], mission: Any, flight: Flight) -> tuple[dict[str, float], bool]:
    """Force and torque of the last five seconds of contact, and how far the foot is from lying flat."""
    end = np.flatnonzero(mission.in_phase("slide")[: flight.ticks])[-1000:]
    touching = np.linalg.norm(flight.signal("contact_force")[end], axis=1) > 0.1
    end = end[touching]
    force = flight.signal("contact_force")[end]
    tip, normal = tips(flight)[end], surface_normal(draw)
    torque = np.cross(flight.signal("contact_point")[end] - tip[:, 0:3], force).mean(axis=0)
    off = float(np.linalg.norm(-torque[1:] - TORQUE))
    push = abs(float(np.linalg.norm(force.mean(axis=0))) - 3.0)
    facing = float(np.degrees(np.arccos(np.clip(tip[:, 3:] @ -normal, -1.0, 1.0))).mean())
    errors = {"force error, N": push, "torque error, N m": off, "angle to the plane, °": facing}
    return errors, push < 0.3 and off < 0.12 and facing < 1.0


def valve_draw(rng: np.random.Generator) -> dict[str, Any]:
    """A valve up to 1 cm off in each direction, that leans by up to 3 degrees and turns harder or easier."""
    return {
        **unknowns(rng),
        "surface_error": rng.uniform(-0.01, 0.01, 3).tolist(),
        "surface.slope": np.radians(rng.uniform(-3.0, 3.0)),
        "surface.pitch": np.radians(rng.uniform(-3.0, 3.0)),
        "surface.lever_angle": np.radians(rng.uniform(-5.0, 5.0)),
        "surface.friction": rng.uniform(0.1, 0.5),
        "surface.friction_torque": rng.uniform(0.2, 0.4),
    }


def valve_score(draw: dict[str, Any], mission: Any, flight: Flight) -> tuple[dict[str, float], bool]:
    """Where the valve stays in the end, the push on its lever, and the body's tilt."""
    # The hinge is the scene's last joint.
    left = 90.0 - np.degrees(flight.signal("configuration")[-1, -1])
    pushing = np.flatnonzero(mission.in_phase("slide")[: flight.ticks])
    push = float(np.quantile(np.linalg.norm(flight.signal("contact_force")[pushing], axis=1), 0.99))
    leaning = float(np.quantile(tilt(flight, before_touch(flight))[pushing], 0.95))
    errors = {"left to turn, °": abs(left), "push, N": push, "body tilt, °": leaning}
    return errors, abs(left) < 1.0 and push < 4.0 and leaning < 1.0


def peg_draw(rng: np.random.Generator) -> dict[str, Any]:
    """A hole up to 8 mm beside its place and 1 cm before or behind it, that leans by up to 3 degrees."""
    return {
        **unknowns(rng),
        "surface_error": [rng.uniform(-0.01, 0.01), *rng.uniform(-0.008, 0.008, 2).tolist()],
        "surface.slope": np.radians(rng.uniform(-3.0, 3.0)),
        "surface.pitch": np.radians(rng.uniform(-3.0, 3.0)),
        "surface.friction": rng.uniform(0.1, 0.3),
    }


def peg_score(draw: dict[str, Any], mission: Any, flight: Flight) -> tuple[dict[str, float], bool]:
    """How far the peg's front is from the floor over the last five seconds, its push there, and out again."""
    surface: Any = skylimb.load_experiment(
        "peg", {k: v for k, v in draw.items() if "controller" not in k}
    ).surface
    robot = skylimb.load_robot("hydrus_xi_quad")
    front = surface.to_local(tips(flight)[:, :3])[:, 0] + robot.description.tip.radius
    end = np.flatnonzero(mission.in_phase("slide")[: flight.ticks])[-1000:]
    left = 1e3 * float(surface.depth - front[end].min())
    force = flight.signal("contact_force")[end].mean(axis=0)
    push = abs(float(-surface.R_WS[:, 0] @ force) - 3.0)
    leaning = float(np.median(tilt(flight, before_touch(flight))[end]))
    out = float(front[-1]) < -0.05
    errors = {"from the floor, mm": left, "force error, N": push, "body tilt, °": leaning}
    return errors, left < 1.0 and push < 0.3 and leaning < 1.0 and out


def tips(flight: Flight) -> np.ndarray:
    """Tip and direction of its link at every tick, W, (k, 6), of hydrus_xi_quad as it really flies."""
    robot = skylimb.load_robot("hydrus_xi_quad")
    q = flight.signal("configuration")
    root = Rotation.from_quat(q[:, [4, 5, 6, 3]])
    found = np.empty((len(q), 6))
    pose = robot.link_pose_function(robot.description.tip.link)
    measured = flight.signal("joint_angles_measured"), flight.signal("vectoring_angles_measured")
    for k in range(len(q)):
        model = np.asarray(pose(measured[0][k], measured[1][k]))
        found[k, :3] = model[:, 0] + model[:, 1:4] @ robot.description.tip.position
        found[k, 3:] = model[:, 1]
    found[:, :3] = q[:, :3] + root.apply(found[:, :3])
    found[:, 3:] = root.apply(found[:, 3:])
    return found


def surface_normal(draw: dict[str, Any]) -> np.ndarray:
    """Outward normal of a draw's plane, W, (3,)."""
    keys = {key: value for key, value in draw.items() if key.startswith("surface.")}
    surface = skylimb.load_experiment("face_to_face", keys).surface
    return -surface.R_WS[:, 0]


TASKS = (
    Task(
        "a foot of 16 cm pushes flat on a plane of unknown lean with 3 N and torques of 0.1 and -0.05 N m",
        "face_to_face",
        {
            **QUICK,
            "controller.contact.force": [3.0, 0.0, 0.0],
            "controller.contact.torque": [0.0, *TORQUE.tolist()],
            "controller.contact.turn_stiffness": [500.0, 0.0, 0.0],
            "controller.contact.turn_damping": [50.0, 15.0, 20.0],
            "controller.attitude.inertia_ratio": [5.0, 1.0, 1.0],
        },
        "mean of 5 s: force within 0.3 N, torque within 0.12 N m; angle to the plane below 1°",
        face_draw,
        face_score,
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
        "mean force vector of 10 s within 0.2 N, body tilt below 0.5°",
        plane_draw,
        plane_score,
    ),
    Task(
        "once around an upright pipe of 0.3 m radius with 1 N",
        "pipe_around",
        QUICK,
        "touch 95 % of the time, mean force within 0.1 N, height within 30 mm and body tilt below 1° (95 %)",
        pipe_draw,
        pipe_score,
    ),
    Task(
        "a valve with 0.2 to 0.4 N m of dry friction is turned by 90° to its stop",
        "valve",
        QUICK,
        "valve within 1° of its stop in the end, push below 4 N (99 %), body tilt below 1° (95 %)",
        valve_draw,
        valve_score,
        None,
    ),
    Task(
        "a peg of 30 mm goes 6 cm into a hole of 34 mm with a chamfer of 2 cm, to its floor, and out again",
        "peg",
        {**QUICK, "phases.hover_end": 2.0},
        "over the last 5 s within 1 mm of the floor, mean push there within 0.3 N of 3 N, body tilt below 1° "
        "(median); in the end out by 5 cm",
        peg_draw,
        peg_score,
        None,
    ),
)


def tasks(count: int, only: list[str]) -> str:
    """A table of the tasks; rows of those that are not flown stay as the page has them."""
    rows = [
        "| task | experiment | tolerance | done | lost | median, 95 % of the errors |",
        "|---|---|---|---|---|---|",
    ]
    kept = {row.split("|")[2].strip(" `"): row for row in section("tasks").splitlines() if "`" in row}
    for task in TASKS:
        if only and task.experiment not in only:
            rows += [kept[task.experiment]] if task.experiment in kept else []
            continue
        rng = np.random.default_rng(7)
        draws = [{**task.wanted, **task.draw(rng)} for _ in range(count)]
        lost, done, errors = 0, 0, []
        for draw, mission, flight in flown(task.experiment, task.controller, draws):
            if flight.cause:
                lost += 1
                continue
            found, good = task.score(draw, mission, flight)
            errors.append(found)
            done += good
        said = "; ".join(
            f"{name} {np.median(values):.3g}, {np.quantile(values, 0.95):.3g}"
            for name in errors[0]
            for values in [[error[name] for error in errors]]
        )
        rows.append(
            f"| {task.name} | `{task.experiment}` | {task.tolerance} | {done} of {count} | {lost} | {said} |"
        )
    return "\n".join(rows)


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


def passivity() -> str:
    """Where the tip's admittance is not passive, and which springs make it grow, along each axis."""
    rows = [
        "| preset | axis | not passive, Hz | least real part, mm/s per N | springs that make it grow, N/m |",
        "|---|---|---|---|---|",
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
            springs = port.along(np.eye(3)[i]).unstable_springs(SPRINGS)
            said = "none" if springs is None else f"{springs[0]:.0f} to {springs[1]:.0f}"
            rows.append(f"| `{name}` | {axis} | {bands or 'none'} | {worst} | {said} |")
    return "\n".join(rows)


def section(name: str) -> str:
    """What the page has between the markers of a section."""
    text = PAGE.read_text(encoding="utf-8")
    return text.partition(f"<!-- {name} -->")[2].partition(f"<!-- end of {name} -->")[0]


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
    given = parser.parse_args()
    parts: dict[str, Callable[[], str]] = {
        "pushes": lambda: pushes(given.draws),
        "tasks": lambda: tasks(given.draws, given.task),
        "stability": stability,
        "passivity": passivity,
    }
    for name in given.part or parts:
        write(name, parts[name]())


if __name__ == "__main__":
    main()
