"""A family of postures for a robot of which nothing is known but its mechanics."""

from __future__ import annotations

import math
from collections.abc import Iterator

import casadi as ca
import numpy as np

from skylimb.robots.description import PostureFamily
from skylimb.robots.held_results import Held
from skylimb.robots.hover import find_hover
from skylimb.robots.model import Robot

_ENOUGH = 0.2
"""Room of the thrusts at which no further posture is tried."""
_ROOM = 0.1
"""How far the nominal posture stays from the joint limits, rad."""
_HALF_RANGE = 0.35
"""How far theta goes to both sides at most, rad."""
_SHARES = (1.0, 0.8, 0.6, 0.4, 0.2)
_PAPERS = (np.array([math.pi / 2, 0.0, 0.0]), np.array([-1.0, 2.0, -1.0]), math.pi / 6)


def choose_posture(robot: Robot) -> tuple[PostureFamily, Held | None]:
    """The first family that hovers with a good margin, else the best one, and how its nominal posture hovers.

    Three parallel joints are tried in the paper's family first. Then the joints about z bend the chain to a
    ring, all by the same angle, which becomes smaller from try to try.
    """
    best: tuple[PostureFamily, Held | None] | None = None
    for offset, slope, nominal in _families(robot):
        family = _with_range(robot, offset, slope, nominal)
        if family is None:
            continue
        hover = find_hover(robot, offset + slope * nominal) or None
        if best is None or (hover is not None and (best[1] is None or hover.room > best[1].room)):
            best = family, hover
        if hover is not None and hover.room > _ENOUGH:
            break
    if best is not None:
        return best
    zero = np.zeros(robot.n_joints)
    return PostureFamily(zero, np.ones(robot.n_joints), -0.01, 0.01, 0.0), None


def _families(robot: Robot) -> Iterator[tuple[np.ndarray, np.ndarray, float]]:
    n = robot.n_joints
    upright = np.array([_upright(robot, name) for name in robot.description.shape_joints])
    if n == 3 and upright.all():
        yield _PAPERS
    bending = upright if upright.any() else np.ones(n)
    ring = 2.0 * math.pi / (np.count_nonzero(bending) + 1.0)
    for share in _SHARES:
        yield np.zeros(n), bending.astype(float), share * min(ring, 0.5 * math.pi)


def _upright(robot: Robot, name: str) -> bool:
    """Whether the joint turns about the root's z while all joints are at zero."""
    poses = robot.link_poses(np.zeros(robot.n_joints), np.zeros(robot.n_vectoring))
    joint = robot.description.joint(name)
    return bool(abs((poses[joint.child][1] @ joint.axis)[2]) > 0.99)


def _with_range(robot: Robot, offset: np.ndarray, slope: np.ndarray, nominal: float) -> PostureFamily | None:
    """The family over the widest range about its nominal posture in which reach changes one way."""
    lower, upper = robot.joint_limits()
    nominal_angles = offset + slope * nominal
    bends = slope != 0.0
    room = np.minimum(nominal_angles - lower, upper - nominal_angles)
    if np.any(room < 0.0) or np.any(room[bends] < _ROOM):
        return None
    reach = _reach(robot)
    half = _HALF_RANGE
    while half > 0.02:
        thetas = np.linspace(nominal - half, nominal + half, 41)
        angles = offset + slope * thetas[:, None]
        inside = np.all((angles >= lower - 1e-9) & (angles <= upper + 1e-9), axis=1)
        thetas = thetas[inside]
        steps = np.diff([float(reach(offset + slope * theta)) for theta in thetas])
        if len(thetas) > 3 and (np.all(steps > 1e-7) or np.all(steps < -1e-7)):
            low, high = min(float(thetas[0]), nominal), max(float(thetas[-1]), nominal)
            return PostureFamily(offset, slope, low, high, nominal)
        half *= 0.7
    return None


def _reach(robot: Robot) -> ca.Function:
    """Distance from the centre of gravity to the tip along its link's heading, as a function of q."""
    q = ca.SX.sym("q", robot.n_joints)
    state = robot.model(q, ca.DM(robot.description.vectoring_start))
    d = state.tip_root - state.cog_root
    along = d[0] * ca.cos(state.tip_heading) + d[1] * ca.sin(state.tip_heading)
    return ca.Function("reach", [q], [along])
