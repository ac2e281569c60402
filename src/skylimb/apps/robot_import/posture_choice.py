"""A family of postures for a robot of which nothing is known but its mechanics."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator

import numpy as np

from skylimb.apps.robot_import.arm_posture import arm_posture
from skylimb.base.errors import UnreachableError
from skylimb.control.planning.posture import widest_family
from skylimb.control.planning.task_family import standing_in
from skylimb.robots.controlled_axes import carried_by_joints
from skylimb.robots.description import PostureFamily
from skylimb.robots.hover import find_hover
from skylimb.robots.model import Robot
from skylimb.robots.touch import can_touch

_ENOUGH = 0.2
"""Room of the thrusts at which no further posture is tried."""
_ROOM = 0.1
"""How far the nominal posture stays from the joint limits, rad."""
_SHARES = (1.0, 0.8, 0.6, 0.4, 0.2)
_PAPERS = (np.array([math.pi / 2, 0.0, 0.0]), np.array([-1.0, 2.0, -1.0]), math.pi / 6)
_CURLED = (1.1, 0.8)
"""Angles of the first joints of a chain whose last link stands out, rad."""
_LAST = (np.array([0.0, 0.5]), np.array([2.0, -1.0]), 0.6)
"""Offset, slope and nominal theta of its last two joints."""
_AHEAD = np.array([1.0, 0.0, 0.0])
_LITTLE = 0.05
"""Room of the thrusts from which on a posture whose tip is ahead goes before one that hovers better."""
_HOPELESS, _MISSES = 0.2, 3
"""By how much of every limit so many postures in a row miss a hover before no other is tried."""


def choose_posture(robot: Robot) -> PostureFamily:
    """The first family whose nominal posture hovers with a good margin, its tip ahead of all; else the best.

    Three joints about z are tried in the paper's family first, then all but two curled up. Then the joints
    about z bend the chain to a ring, all by the same angle, which becomes smaller from try to try. An
    arm, whose joints carry no rotor, stands where `arm_posture` finds its tip foremost.
    """
    arm = arm_posture(robot) if robot.n_joints and not carried_by_joints(robot) else None
    if arm is not None:
        with contextlib.suppress(UnreachableError):
            return standing_in(robot, np.round(arm, 3), robot.description.vectoring_start).description.posture
    lower, upper = robot.joint_limits()
    rest = np.clip(np.zeros(robot.n_joints), lower, upper)
    best, most = PostureFamily(rest, np.ones(robot.n_joints), -0.01, 0.01, 0.0), (False, -math.inf)
    missed = 0
    for offset, slope, nominal in _families(robot):
        angles = offset + slope * nominal
        room = np.minimum(angles - lower, upper - angles)
        if np.any(room < np.where(slope == 0.0, 0.0, _ROOM)):
            continue
        family = widest_family(robot, offset, slope, nominal)
        if family is None:
            continue
        hover = find_hover(robot, angles)
        missed = 0 if hover or hover.excess < _HOPELESS else missed + 1
        if missed == _MISSES:
            break
        left = hover.room if hover else -1.0
        ahead = bool(hover and left > _LITTLE and can_touch(robot, angles, hover.vectoring_angles, _AHEAD))
        if (ahead, left) > most:
            best, most = family, (ahead, left)
        if ahead and left > _ENOUGH:
            break
    return best


def _families(robot: Robot) -> Iterator[tuple[np.ndarray, np.ndarray, float]]:
    n = robot.n_joints
    upright = np.array([_upright(robot, name) for name in robot.description.shape_joints])
    about_z = np.flatnonzero(upright)
    if len(about_z) == 3:
        offset, slope, nominal = _PAPERS
        yield _at(n, about_z, offset), _at(n, about_z, slope), nominal
    if len(about_z) >= 3:
        offset, slope, nominal = _LAST
        for curled in _CURLED:
            angles = np.concatenate([np.full(len(about_z) - 2, curled), offset])
            yield _at(n, about_z, angles), _at(n, about_z[-2:], slope), nominal
    bending = upright if upright.any() else np.ones(n)
    ring = 2.0 * math.pi / (np.count_nonzero(bending) + 1.0)
    for share in _SHARES:
        yield np.zeros(n), bending.astype(float), share * min(ring, 0.5 * math.pi)


def _at(n: int, joints: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values of some joints among n, the others zero."""
    whole = np.zeros(n)
    whole[joints] = values
    return whole


def _upright(robot: Robot, name: str) -> bool:
    """Whether the joint turns about the root's z while all joints are at zero."""
    poses = robot.link_poses(np.zeros(robot.n_joints), np.zeros(robot.n_vectoring))
    joint = robot.description.joint(name)
    return bool(abs((poses[joint.child][1] @ joint.axis)[2]) > 0.99)
