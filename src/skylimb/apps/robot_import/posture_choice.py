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
from skylimb.robots.description import PostureFamily
from skylimb.robots.hover import find_hover
from skylimb.robots.model import Robot

_ENOUGH = 0.2
"""Room of the thrusts at which no further posture is tried."""
_ROOM = 0.1
"""How far the nominal posture stays from the joint limits, rad."""
_SHARES = (1.0, 0.8, 0.6, 0.4, 0.2)
_PAPERS = (np.array([math.pi / 2, 0.0, 0.0]), np.array([-1.0, 2.0, -1.0]), math.pi / 6)


def choose_posture(robot: Robot) -> PostureFamily:
    """The first family whose nominal posture hovers with a good margin, else the one that hovers best.

    Three parallel joints are tried in the paper's family first. Then the joints about z bend the chain to a
    ring, all by the same angle, which becomes smaller from try to try. An arm, whose joints carry no rotor,
    stands where `arm_posture` finds its tip foremost.
    """
    arm = arm_posture(robot) if _carries_no_rotor(robot) else None
    if arm is not None:
        with contextlib.suppress(UnreachableError):
            return standing_in(robot, np.round(arm, 3), robot.description.vectoring_start).description.posture
    zero = np.zeros(robot.n_joints)
    best, most = PostureFamily(zero, np.ones(robot.n_joints), -0.01, 0.01, 0.0), -math.inf
    lower, upper = robot.joint_limits()
    for offset, slope, nominal in _families(robot):
        angles = offset + slope * nominal
        room = np.minimum(angles - lower, upper - angles)
        if np.any(room < np.where(slope == 0.0, 0.0, _ROOM)):
            continue
        family = widest_family(robot, offset, slope, nominal)
        if family is None:
            continue
        hover = find_hover(robot, angles)
        left = hover.room if hover else -1.0
        if left > most:
            best, most = family, left
        if left > _ENOUGH:
            break
    return best


def _families(robot: Robot) -> Iterator[tuple[np.ndarray, np.ndarray, float]]:
    n = robot.n_joints
    upright = np.array([_upright(robot, name) for name in robot.description.shape_joints])
    if n == 3 and upright.all():
        yield _PAPERS
    bending = upright if upright.any() else np.ones(n)
    ring = 2.0 * math.pi / (np.count_nonzero(bending) + 1.0)
    for share in _SHARES:
        yield np.zeros(n), bending.astype(float), share * min(ring, 0.5 * math.pi)


def _carries_no_rotor(robot: Robot) -> bool:
    """Whether no joint that bends moves a rotor."""
    q, psi = robot.nominal_posture(), robot.description.vectoring_start
    bent = robot.link_poses(q + 0.5, psi)
    same = (
        np.allclose(bent[r.link][0], at)
        for r in robot.description.rotors
        for at in [robot.link_poses(q, psi)[r.link][0]]
    )
    return robot.n_joints > 0 and all(same)


def _upright(robot: Robot, name: str) -> bool:
    """Whether the joint turns about the root's z while all joints are at zero."""
    poses = robot.link_poses(np.zeros(robot.n_joints), np.zeros(robot.n_vectoring))
    joint = robot.description.joint(name)
    return bool(abs((poses[joint.child][1] @ joint.axis)[2]) > 0.99)
