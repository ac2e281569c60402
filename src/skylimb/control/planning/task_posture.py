"""The posture for a task: joint angles, heading and vectoring angles with the greatest worst margin.

While the tip presses on the surface with each of some pushes (normal force and the drag of friction, along
the path), the robot is at rest as `robots.equilibrium` has it: every thrust within its limits, no servo
beyond its share, joints where the servos hold them, leaning for each push by a lean of its own. The least
margin over the pushes is maximised over q, the heading, psi and all thrusts, within joint limits, with links
apart and rotors clear of the surface: one nonlinear programme with exact derivatives from CasADi. It begins
in the nominal posture and in some others, the same every time. Where nothing holds the pushes, the same
programme says which share of them can be held.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from skylimb.base.errors import UnreachableError
from skylimb.control.planning.nlp import distinct
from skylimb.control.planning.task import Task, TaskPosture, judged_posture, travel
from skylimb.control.planning.task_program import TaskProgram
from skylimb.robots.equilibrium_results import NotHeld
from skylimb.robots.model import Robot
from skylimb.robots.starts import evenly

_STARTS = 24
"""Searches; a third of them end without a posture, and half of the others meet in the same one."""

_FEW, _FAR = 6, 0.8
"""Searches after which, all without a posture, the share of the pushes that can be held is looked for; below
the second number the others are left out."""

_SAME = 0.05
"""Postures closer than this in every joint are one, rad."""


def best_postures(robot: Robot, task: Task, start: TaskPosture) -> list[TaskPosture]:
    """The postures with the greatest worst margin that searches from several starts find, best first.

    Args:
        robot: of four rotors or more.
        task: what the tip has to do.
        start: where the search begins; of its angles alone.

    Raises:
        UnreachableError: no posture that the search finds can do it. The message names what is in the way,
            and the share of the pushes that can be held.
    """
    program, starts = TaskProgram(robot, len(task.pushes), task.criteria), _starts(robot, start)
    found = [one for one in (program.solve(task, first) for first in starts[:_FEW]) if one is not None]
    nearest = None if found else _nearest(program, task, starts)
    if found or (nearest is not None and nearest.share > _FAR):
        found += [one for one in (program.solve(task, other) for other in starts[_FEW:]) if one is not None]
    best = distinct(sorted(found, key=lambda one: -one.margin), lambda one: one.angles, _SAME)
    if not best:
        raise UnreachableError(_nothing_holds(robot, task, nearest))
    return best


def _starts(robot: Robot, start: TaskPosture) -> list[TaskPosture]:
    """The given posture, and others spread evenly over joint and vectoring angles.

    Each branch of vectoring angles ends somewhere else.
    """
    nq, turns = robot.n_joints, robot.vectoring_limits()
    lower, upper = (
        np.concatenate([some, np.clip(turn, -math.pi, math.pi)])
        for some, turn in zip(travel(robot), turns, strict=True)
    )
    others = evenly(lower, upper, _STARTS - 1)
    return [start, *(replace(start, joint_angles=x[:nq], vectoring_angles=x[nq:]) for x in others)]


def _nearest(program: TaskProgram, task: Task, starts: list[TaskPosture]) -> TaskPosture | None:
    """The posture that holds the greatest share of the pushes."""
    tried = [program.solve(task, one, most=True) for one in starts]
    return max((one for one in tried if one is not None), key=lambda one: one.share, default=None)


def _nothing_holds(robot: Robot, task: Task, nearest: TaskPosture | None) -> str:
    """In words: what is in the way, and how much can be held."""
    said = f"'{robot.name}' cannot do this task: no posture holds all of the {len(task.pushes)} pushes"
    if nearest is None or nearest.share <= 0.0:
        apart = f"links {task.clearance:g} m apart and rotors {task.room:g} m off the surface"
        return f"{said} within its limits, nor any share of them, with {apart}"
    there = nearest.joint_angles, nearest.vectoring_angles, nearest.heading
    judged = judged_posture(robot, task, *there)
    why = f": {judged}" if isinstance(judged, NotHeld) else ""
    return f"{said}{why}; what can be held is at most {nearest.share * task.force:.1f} N"
