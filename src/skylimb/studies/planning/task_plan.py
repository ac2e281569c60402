"""The posture for an experiment: the pushes of its path, and the experiment written with that posture."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import tomli_w

from skylimb.base.config import parse_toml, write_toml
from skylimb.base.errors import ConfigError, DescriptionError, UnreachableError
from skylimb.base.files import new_folder
from skylimb.base.rotations import rot_z
from skylimb.base.sources import read_source
from skylimb.control.controller import Controller
from skylimb.control.needs import TORQUE
from skylimb.control.planning.posture import standing
from skylimb.control.planning.task import Task, TaskPosture, judged_posture
from skylimb.control.planning.task_family import settled_in
from skylimb.control.planning.task_posture import best_postures
from skylimb.control.planning.vectoring import PURPOSES, vectoring_table
from skylimb.control.planning.vectoring_digest import robot_digest
from skylimb.control.planning.vectoring_files import table_file, write_table
from skylimb.flight.experiments.experiment import Experiment, load_experiment, require_contact
from skylimb.flight.feasible import hardest_needs
from skylimb.flight.loading import load_flight
from skylimb.flight.plan import mission_of
from skylimb.robots.equilibrium_results import NotHeld, Within
from skylimb.robots.loader import FLIGHT_FILE, load_robot
from skylimb.robots.model import Robot
from skylimb.studies.planning.rehearsal import Rehearsal, rehearse

_POINTS = 8
"""Points of the path at which the push is looked at."""

FORCE = 3.0
"""Normal force where neither the user nor the controller says one, N."""

EXPERIMENT = "experiment.toml"

By = Literal["flight", "margin"]
"""What counts between two postures that hold the pushes."""


@dataclass(frozen=True, eq=False)
class TaskPlan:
    """A posture for an experiment beside the robot's own.

    Attributes:
        experiment: for which it was found.
        robot: as the experiment has it, or its pairs: the robot that laws fly.
        task: the pushes along the path.
        points: of the path, W, m, (k, 3).
        force: normal force, N.
        nominal: the nominal posture, or what is in the way of the pushes there.
        planned: the posture that was found.
        there: the robot standing in it.
        coefficients: of its vectoring angles over its family, Chebyshev, (nv, degree + 1).
        own_flight: how the experiment was flown in the nominal posture, where it holds the pushes.
        planned_flight: and in the one that was found; None of a robot without files.
    """

    experiment: Experiment
    robot: Robot
    task: Task
    points: np.ndarray
    force: float
    nominal: TaskPosture | NotHeld
    planned: TaskPosture
    there: Robot
    coefficients: np.ndarray
    own_flight: Rehearsal | None = None
    planned_flight: Rehearsal | None = None


def plan(
    experiment: str | Experiment = "paper",
    controller: str | Controller = "hybrid",
    force: float | None = None,
    set: Mapping[str, Any] | None = None,
    by: By = "flight",
) -> TaskPlan:
    """The posture that leaves the rotors the most torque all along an experiment's path.

    Args:
        experiment: a name, a TOML file, or an experiment at hand.
        controller: what is to fly it: a name, a file, or a controller at hand.
        force: normal force, N; by default the greatest of `trajectory.force`, else the controller's, else
            3 N.
        set: dotted keys of the experiment, or of the controller with "controller." in front, and new values.
        by: what counts, see `plan_posture`.

    Returns:
        The posture beside the robot's own; `write_planned` makes an experiment of it.

    Raises:
        ConfigError: the experiment touches nothing, or its path stands still.
        UnreachableError: no posture can do it, or none of those that can be held is flown without a loss.
    """
    loaded = load_flight(experiment, controller, set=set)
    return plan_posture(loaded.experiment, loaded.robot, loaded.controller, force, by)


def plan_posture(
    experiment: Experiment,
    robot: Robot,
    controller: Controller,
    force: float | None = None,
    by: By = "flight",
) -> TaskPlan:
    """The posture with the greatest worst margin along an experiment's path, of those that fly it well.

    At `_POINTS` points of the slide the tip presses along the surface's normal and drags with its friction.
    Each posture is flown before it is proposed, with the force that was asked.

    Args:
        experiment: with a surface and a path.
        robot: the experiment's.
        controller: what is to fly it; it says which force it commands, and what its vectoring angles keep.
        force: normal force, N; by default the greatest of `trajectory.force`, else the controller's, else
            `FORCE`.
        by: "flight" proposes nothing that flies worse than the robot's own posture, see `Rehearsal`;
            "margin" whatever is not lost.

    Raises:
        ConfigError: the experiment touches nothing, or its path stands still.
        UnreachableError: no posture can do it, or none of those that can be held flies well enough.
    """
    require_contact(experiment, f"experiment {experiment.name}", "plan")
    needs = hardest_needs(experiment, controller)
    robot = standing(robot.pairs, needs.vectoring)
    wanted = force if force is not None else needs.force or FORCE
    if not 0.0 < wanted < 1e3:
        raise ConfigError(f"force = {wanted:g} N is outside of 0 .. 1000 N")
    if force is not None and needs.force:
        pressed = replace(experiment.trajectory, force=(force, force))
        experiment = replace(experiment, trajectory=pressed)
    task, points = _task(experiment, robot, needs.vectoring, wanted)
    table = vectoring_table(robot, needs.vectoring)
    psi = np.asarray(table.angles(robot.description.posture.theta_nominal), dtype=float)
    nominal = judged_posture(
        robot, task, robot.nominal_posture(), psi, within=Within(experiment.terminations.tilt)
    )
    nothing = np.zeros((len(points), robot.n_rotors))
    start = TaskPosture(robot.nominal_posture(), psi, 0.0, nothing, nothing[:, 0])
    judged = by == "flight" and bool(nominal)
    own = rehearse(experiment, controller) if nominal else None
    least = nominal.margin if nominal and judged else -math.inf
    why = "none leaves the tip a way to and fro on which the vectoring angles suit the task"
    missed, short = list[NotHeld](), ""
    for posture in _as_flown(robot, task, best_postures(robot, task, start), missed, least):
        plan = TaskPlan(experiment, robot, task, points, wanted, nominal, *posture)
        flown = _flown(plan, controller)
        why = flown.lost if flown else ""
        worse = flown.worse_than(own) if judged and flown and own and not why else ""
        if not why and not worse:
            return replace(plan, own_flight=own, planned_flight=flown)
        short = short or (worse and f"; that with {posture[0].margin:.2f} N m: {worse}")
    if nominal and judged:
        raise UnreachableError(
            f"'{robot.name}' stands best as it does: no posture that leaves more torque than its own "
            f"({nominal.margin:.2f} N m) flies {experiment.name} as well{short}; "
            'by = "margin" (--by margin) takes the most torque that is not lost'
        )
    nearest = max(missed, key=lambda one: one.greatest or 0.0, default=None)
    if nearest is not None:
        why = f"{nearest}, with the vectoring angles that suit the whole of its family"
        why += f"; what can be held is {nearest.greatest:.1f} N" if nearest.greatest else ""
    raise UnreachableError(
        f"'{robot.name}' cannot do this task: no posture that holds {wanted:g} N flies {experiment.name}: "
        f"{why}"
    )


def _as_flown(
    robot: Robot, task: Task, postures: list[TaskPosture], missed: list[NotHeld], least: float
) -> Iterator[tuple[TaskPosture, Robot, np.ndarray]]:
    """Postures with the vectoring angles that suit their whole family, the greatest margin first.

    None leaves less than `least`, N m. `missed` gets what is in the way of those that these do not hold.
    """
    settled: list[tuple[TaskPosture, Robot, np.ndarray]] = []
    for posture in postures:
        if posture.margin <= least:
            break
        # What suits a whole family leaves no more than what suits one posture of it.
        yield from _taken(settled, posture.margin)
        found = settled_in(robot, task, posture)
        if isinstance(found, NotHeld):
            missed.append(found)
        elif found is not None:
            settled.append(found)
    yield from _taken(settled, least)


def _taken(
    settled: list[tuple[TaskPosture, Robot, np.ndarray]], least: float
) -> Iterator[tuple[TaskPosture, Robot, np.ndarray]]:
    settled.sort(key=lambda one: one[0].margin)
    while settled and settled[-1][0].margin >= least:
        yield settled.pop()


def _flown(plan: TaskPlan, controller: Controller) -> Rehearsal | None:
    """How the experiment is flown in the planned posture.

    A margin at rest does not say that a controller holds the robot there: thrusts that tilt it may push it
    the other way first, faster than the controller looks on. A posture in which no robot is flown, as its
    tool gives no heading, counts as lost. A robot made in Python has no files to fly from, and is taken as
    planned.
    """
    if not plan.robot.description.sources:
        return None
    with tempfile.TemporaryDirectory() as folder:
        try:
            write_planned(plan, Path(folder) / "planned")
        except DescriptionError as error:
            return Rehearsal(str(error))
        return rehearse(load_experiment(str(Path(folder) / "planned" / EXPERIMENT)), controller)


def _task(experiment: Experiment, robot: Robot, purpose: str, force: float) -> tuple[Task, np.ndarray]:
    mission, surface = mission_of(experiment, robot, purpose), experiment.surface
    slide = np.flatnonzero(mission.in_phase("slide"))
    chosen = slide[np.linspace(0, max(len(slide) - 2, 0), _POINTS).astype(int)]
    on_path, motion = mission.tip_path[chosen], mission.tip_path[chosen + 1] - mission.tip_path[chosen]
    speed = np.linalg.norm(motion, axis=1, keepdims=True)
    if not np.all(np.isfinite(on_path)) or not np.any(speed > 0.0):
        raise ConfigError(f"experiment {experiment.name}: the tip stands still; there is no path to plan for")
    feet = surface.project(on_path)
    normals = surface.normal(feet)
    along = motion / np.where(speed > 0.0, speed, 1.0)
    along -= np.sum(along * normals, axis=1, keepdims=True) * normals
    friction = float(getattr(surface, "friction", 0.0))
    turn = rot_z(-mission.frame.heading).T
    pushes = force * (-normals + friction * along)
    criteria = PURPOSES.get(purpose, PURPOSES[TORQUE])
    return Task(pushes @ turn, normals @ turn, criteria=criteria), feet


def write_planned(plan: TaskPlan, out: str | Path) -> None:
    """A new folder with the experiment and its robot standing in the planned posture.

    `experiment.toml` flies it: `skylimb run DIR/experiment.toml`. Of the robot, only the family of postures
    and the vectoring angles are others.

    Raises:
        OutputError: the folder cannot be made.
        UnreachableError: the robot was not read from files, so there are none to write.
    """
    experiment, description = plan.experiment, plan.robot.description
    if not description.sources:
        raise UnreachableError(f"'{plan.robot.name}' was made in Python; only robots of files can be written")
    family = plan.there.description.posture
    flight = parse_toml(description.sources[0])
    flight["posture"] = {
        "offset": family.offset.tolist(),
        "slope": family.slope.tolist(),
        **{key: float(getattr(family, key)) for key in ("theta_min", "theta_max", "theta_nominal")},
    }
    if plan.robot.n_vectoring:
        flight["vectoring"]["start"] = plan.planned.vectoring_angles.tolist()
    with new_folder(out) as folder:
        (folder / "robot").mkdir()
        for source in description.sources[1:]:
            _beside(folder / "robot", source.path, description.folder).write_bytes(source.content)
        for link in description.links:
            for visual in link.visuals:
                if visual.mesh is not None:
                    mesh = read_source(visual.mesh).content
                    _beside(folder / "robot", visual.mesh, description.folder).write_bytes(mesh)
        (folder / "robot" / FLIGHT_FILE).write_text(tomli_w.dumps(flight), encoding="utf-8")
        robot = load_robot(str(folder / "robot"))
        criteria = plan.task.criteria
        if plan.robot.n_vectoring:
            found = np.round(plan.coefficients, 10)
            write_table(
                folder / "robot" / table_file(criteria), found, robot_digest(robot, criteria), robot, criteria
            )
        approach = replace(experiment.approach, heading=experiment.approach.heading + plan.planned.heading)
        flown = replace(experiment, robot="robot", approach=approach)
        (folder / EXPERIMENT).write_text(write_toml(flown.to_mapping()), encoding="utf-8")


def _beside(folder: Path, path: Path, home: Path) -> Path:
    """Where a file of the robot's folder goes in the new one."""
    there = folder / (path.relative_to(home) if path.is_relative_to(home) else path.name)
    there.parent.mkdir(parents=True, exist_ok=True)
    return there
