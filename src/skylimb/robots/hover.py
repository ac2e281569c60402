"""The steadiest hover of a posture: `robots.equilibrium` without a push, with vectoring angles free."""

from __future__ import annotations

import functools
import math

import numpy as np

from skylimb.robots.equilibrium import hovers, hovers_and_margins, steadiest
from skylimb.robots.equilibrium_results import Held, NotHeld, Within
from skylimb.robots.model import Robot

LEVEL = 5e-3
"""Tilt up to which a hover counts as level, rad."""

TILTED = 1.0
"""Greatest tilt of the measured link in a hover that is not level, rad."""


def find_hover(robot: Robot, joint_angles: np.ndarray) -> Held | NotHeld:
    """The hover with the most room for every thrust: level where that is possible, tilted where it must be.

    Args:
        robot: any robot with rotors; fewer than four are allowed.
        joint_angles: q as commanded, rad, (nq,).
    """
    level = steadiest(_searched(robot, tuple(joint_angles), LEVEL, False))
    return level or steadiest(_searched(robot, tuple(joint_angles), TILTED, False))


@functools.lru_cache(maxsize=8)
def _searched(
    robot: Robot, joint_angles: tuple[float, ...], tilt: float, stiff: bool
) -> tuple[tuple[Held | NotHeld, float], ...]:
    """What all searches of a hover lead to; a check of a robot asks for it again and again."""
    within, start = Within(tilt, math.inf, stiff=stiff), robot.description.vectoring_start
    return tuple(hovers_and_margins(robot, np.array(joint_angles), start, within))


def any_hover(robot: Robot, joint_angles: np.ndarray) -> Held | NotHeld:
    """The first hover that a search meets, tilted or not; else what is nearest to one."""
    missed: list[NotHeld] = []
    for found in hovers(robot, joint_angles, robot.description.vectoring_start, Within(TILTED, math.inf)):
        if isinstance(found, Held):
            return found
        missed.append(found)
    return min(missed, key=lambda one: one.excess)


def find_hovers(robot: Robot, joint_angles: np.ndarray, *, stiff: bool = False) -> list[Held]:
    """Every hover that a search of `find_hover` ends in; tilted ones where none is level.

    With `stiff`, the joint angles are where the joints rest.
    """
    for tilt in (LEVEL, TILTED):
        searched = _searched(robot, tuple(joint_angles), tilt, stiff)
        found = [one for one, _ in searched if isinstance(one, Held)]
        if found:
            return found
    return []


def cannot_hover(robot: Robot, joint_angles: np.ndarray, found: NotHeld) -> str:
    """The words for a robot that a check or a take-off refuses."""
    where = f" at q = {np.round(joint_angles, 3).tolist()} rad" if robot.n_joints else ""
    return f"'{robot.name}' cannot hover{where}: {found}"
