"""What the tip has to do, a posture for it, and whether a posture holds it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from skylimb.base.rotations import rot_z
from skylimb.control.planning.vectoring_criteria import TORQUE, VectoringCriteria
from skylimb.robots.equilibrium import can_hold
from skylimb.robots.equilibrium_results import TILT, NotHeld, Within
from skylimb.robots.model import Robot

WITHIN = Within(TILT)
"""What a planned posture keeps for every push."""

_TRAVEL = 0.3
"""How far joints stay from their limits, so that the arm can give way, rad."""


@dataclass(frozen=True, eq=False)
class Task:
    """What the tip has to do, in the level frame whose x axis is the contact axis's heading.

    Attributes:
        pushes: of the tip on the surface, N, (k, 3).
        normals: of the surface where each acts, unit, outward, (k, 3).
        clearance: least distance between links that are not joined, m.
        room: least distance of rotors' discs and links' origins to the plane of the surface, m.
        criteria: what the vectoring angles keep.
    """

    pushes: np.ndarray
    normals: np.ndarray
    clearance: float = 0.1
    room: float = 0.03
    criteria: VectoringCriteria = TORQUE

    @property
    def force(self) -> float:
        """The normal force of the hardest push, N."""
        return float(-np.sum(self.pushes * self.normals, axis=1).min())


@dataclass(frozen=True, eq=False)
class TaskPosture:
    """A posture for a task.

    Attributes:
        joint_angles: q, rad, (nq,).
        vectoring_angles: psi, rad, (nv,).
        heading: beside the contact axis, rad.
        thrusts: while it presses, N, (k, n).
        margins: torque that is left about any axis, N m, (k,).
        share: of the pushes that is held.
    """

    joint_angles: np.ndarray
    vectoring_angles: np.ndarray
    heading: float
    thrusts: np.ndarray
    margins: np.ndarray
    share: float = 1.0

    @property
    def angles(self) -> np.ndarray:
        """All joints and the heading, rad, (nq + nv + 1,)."""
        return np.concatenate([self.joint_angles, self.vectoring_angles, [self.heading]])

    @property
    def margin(self) -> float:
        """The worst, N m."""
        return float(self.margins.min())


def judged_posture(
    robot: Robot,
    task: Task,
    joint_angles: np.ndarray,
    vectoring_angles: np.ndarray,
    heading: float = 0.0,
    within: Within = WITHIN,
) -> TaskPosture | NotHeld:
    """A posture as it is: thrusts and margin for every push; else what is in the way of the hardest one.

    What can be held the greatest of is then the normal force.
    """
    turned = task.pushes @ rot_z(-heading).T
    found = [can_hold(robot, joint_angles, vectoring_angles, push, within) for push in turned]
    missed = [
        # Of the whole push, friction and all, to the force that presses.
        replace(one, greatest=one.greatest and one.greatest / float(np.linalg.norm(push)) * task.force)
        for one, push in zip(found, turned, strict=True)
        if isinstance(one, NotHeld)
    ]
    if missed:
        return min(missed, key=lambda one: one.greatest or 0.0)
    held = [one for one in found if not isinstance(one, NotHeld)]
    return TaskPosture(
        np.asarray(joint_angles, dtype=float),
        np.asarray(vectoring_angles, dtype=float),
        heading,
        np.array([one.thrusts for one in held]),
        np.array([one.margin for one in held]),
    )


def travel(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """Joint angles within which a posture leaves the arm some way to go, rad, (nq,) each."""
    lower, upper = (np.clip(limit, -math.pi, math.pi) for limit in robot.joint_limits())
    room = np.minimum(_TRAVEL, 0.25 * (upper - lower))
    return lower + room, upper - room
