"""Joint angles that put the tip where it is wanted: inverse kinematics of any tree of joints that turn.

The robot flies, so its own place and yaw are free. What the joints decide is where the tip is from the centre
of gravity, seen with the heading along x, and how the tool is turned there. The angles are found by a
nonlinear program with exact derivatives from CasADi: nearest to a wanted posture, within the joint limits,
with links apart from each other. What is left over moves in the null space, towards that posture.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from skylimb.base.errors import ConfigError, UnreachableError
from skylimb.control.planning.nlp import ipopt, search
from skylimb.robots.model import Robot
from skylimb.robots.starts import evenly

_STARTS = 8
_ITERATIONS = 200
_NEAR = 1e-6
_UPRIGHT = 0.5 * math.pi + 1e-9
_HAND = 0.1
"""Origins of joints that are closer than this are one place, m."""

_SHARES = (0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0)
"""Where the points lie on a link whose distances to other links' points are kept."""


@dataclass(frozen=True, eq=False)
class TipTarget:
    """Where the tip shall be.

    Attributes:
        position: (3,) from the centre of gravity, m: along the heading, to its left, up.
        elevation: wanted angle of the tool's x axis above the horizontal plane, rad; None leaves it free.
        orientation: (3, 3) wanted of the tool, in the same axes; None leaves it free.
        clearance: least distance between points of links that are not joined to each other, m.
    """

    position: np.ndarray
    elevation: float | None = None
    clearance: float = 0.0
    orientation: np.ndarray | None = None

    def __post_init__(self) -> None:
        """Refuse what is no place, no angle or no orientation."""
        _require("position", self.position, (3,), "numbers (m)")
        if self.orientation is not None:
            _require("orientation", self.orientation, (3, 3), "numbers")
        if self.elevation is not None and not abs(self.elevation) <= _UPRIGHT:
            raise ConfigError(
                f"elevation = {self.elevation:g} rad of a tip's target must be within -pi/2 and pi/2"
            )


def _require(name: str, value: Any, shape: tuple[int, ...], what: str) -> None:
    try:
        given = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        given = None
    if given is None or given.shape != shape or not np.all(np.isfinite(given)):
        size, told = " x ".join(map(str, shape)), value if given is None else given.tolist()
        raise ConfigError(f"{name} = {told!r} of a tip's target must be {size} finite {what}")


def tip_position(robot: Robot, joint_angles: np.ndarray, vectoring_angles: np.ndarray) -> np.ndarray:
    """Where the tip is, as `TipTarget.position` counts: (3,), m."""
    return _geometry(robot)(*robot.checked_angles(joint_angles, vectoring_angles))[0].full().ravel()


def tip_jacobian(robot: Robot, joint_angles: np.ndarray, vectoring_angles: np.ndarray) -> np.ndarray:
    """Derivative of `tip_position` by the joint angles: (3, nq), m/rad."""
    return _geometry(robot)(*robot.checked_angles(joint_angles, vectoring_angles))[3].full()


def null_space(robot: Robot, joint_angles: np.ndarray, vectoring_angles: np.ndarray) -> np.ndarray:
    """Orthonormal moves of the joints that keep the tip's position: (nq, k)."""
    _, values, rows = np.linalg.svd(tip_jacobian(robot, joint_angles, vectoring_angles))
    return rows[int(np.count_nonzero(values > 1e-9 * max(values.max(initial=0.0), 1e-12))) :].T


def find_posture(
    robot: Robot,
    target: TipTarget,
    near: np.ndarray | None = None,
    vectoring_angles: np.ndarray | None = None,
) -> np.ndarray:
    """Joint angles (nq,) in rad that reach the target, the nearest ones to a posture that is liked.

    Args:
        robot: any robot with bending joints.
        target: where the tip shall be.
        near: (nq,) the posture to stay near, rad; the nominal one by default.
        vectoring_angles: (nv,) held meanwhile, rad; where their search begins by default.

    Raises:
        ConfigError: the robot does not bend, or a number of angles is wrong.
        UnreachableError: no posture within the joint limits reaches it; the message names the nearest tip.
    """
    if robot.n_joints == 0:
        raise ConfigError(f"'{robot.name}' has no bending joints: its tip stays where it is")
    near = robot.nominal_posture() if near is None else np.asarray(near, dtype=float)
    if near.shape != (robot.n_joints,):
        raise ConfigError(f"near has {near.size} angles; '{robot.name}' has {robot.n_joints} bending joints")
    held = robot.description.vectoring_start if vectoring_angles is None else vectoring_angles
    near, psi = robot.checked_angles(near, held)
    lower, upper = (np.clip(limit, -math.pi, math.pi) for limit in robot.joint_limits())
    position = np.asarray(target.position, dtype=float)
    wanted = np.eye(3) if target.orientation is None else np.asarray(target.orientation, dtype=float)
    parameters = [*position, math.sin(target.elevation or 0.0), *wanted.ravel(order="F"), *near, *psi]
    turned = target.orientation is not None
    solver, pairs = _solver(robot, target.elevation is not None, turned, target.clearance > 0.0)
    held = [0.0] * (3 + (target.elevation is not None) + 3 * turned)
    open_ = [0.0] * 2 * turned + [target.clearance**2] * pairs
    bounds = {"lbx": lower, "ubx": upper, "lbg": [*held, *open_], "ubg": [*held, *[np.inf] * len(open_)]}
    best: tuple[float, np.ndarray] | None = None
    for start in [np.clip(near, lower, upper), *evenly(lower, upper, _STARTS - 1)]:
        found = search(solver, start, p=parameters, **bounds)
        if found is not None and (best is None or found[0] < best[0] - _NEAR):
            best = found
        if best is not None and best[0] < _NEAR:
            break
    if best is None:
        raise UnreachableError(_nearest(robot, target, psi, lower, upper))
    return best[1]


def _nearest(robot: Robot, target: TipTarget, psi: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> str:
    q, p = ca.SX.sym("q", robot.n_joints), ca.SX.sym("p", 3)
    miss = ca.sumsqr(_geometry(robot)(q, ca.DM(psi))[0] - p)
    solver = ipopt({"x": q, "p": p, "f": miss}, _ITERATIONS)
    starts = [np.clip(robot.nominal_posture(), lower, upper), 0.5 * (lower + upper)]
    solutions = [solver(x0=start, p=target.position, lbx=lower, ubx=upper) for start in starts]
    best = min(solutions, key=lambda solution: float(solution["f"]))
    tip = tip_position(robot, best["x"].full().ravel(), psi)
    away = math.sqrt(max(float(best["f"]), 0.0))
    asked = np.round(np.asarray(target.position, dtype=float), 4).tolist()
    more = "; its orientation or the clearance forbids it" if away < 1e-3 else ""
    return (
        f"no posture of '{robot.name}' within its joint limits puts the tip at {asked} m from the centre of "
        f"gravity; the nearest tip is {np.round(tip, 4).tolist()} m, {away:.3g} m away{more}"
    )


@functools.lru_cache(maxsize=16)
def _geometry(robot: Robot) -> ca.Function:
    """(q, psi) -> tip (3,), the tool's axes (3, 3), points on the links (3, k), Jacobian of the tip."""
    q, psi = ca.SX.sym("q", robot.n_joints), ca.SX.sym("psi", robot.n_vectoring)
    state = robot.model(q, psi)
    d, yaw = state.tip_root - state.cog_root, state.tip_heading
    c, s = ca.cos(yaw), ca.sin(yaw)
    tip = ca.vertcat(c * d[0] + s * d[1], c * d[1] - s * d[0], d[2])
    axes = robot.tool(q, psi)[0][:, 1:]
    axes = ca.vertcat(c * axes[0, :] + s * axes[1, :], c * axes[1, :] - s * axes[0, :], axes[2, :])
    points = [
        (1.0 - share) * robot.link_pose_function(one)(q, psi)[:, 0]
        + share * (robot.link_pose_function(other)(q, psi)[:, 0] if other else state.tip_root)
        for one, other in _segments(robot)
        for share in _SHARES
    ]
    return ca.Function("geometry", [q, psi], [tip, axes, ca.horzcat(*points), ca.jacobian(tip, q)])


def _segments(robot: Robot) -> list[tuple[str, str]]:
    """Pairs of links between whose origins something rigid lies; the tip's has no second one.

    Joints that follow each other within `_HAND` are one: a link between them is no segment.
    """
    description = robot.description
    bending = {description.joint(name).child for name in description.shape_joints}
    above = {joint.child: joint.parent for joint in description.joints}
    poses = robot.link_poses(robot.nominal_posture(), robot.description.vectoring_start)

    def anchor(link: str) -> str:
        while link not in bending and link in above:
            link = above[link]
        return link

    def first(link: str) -> str:
        """The first of the joints that a link's own follows at once."""
        before = anchor(above[link]) if link in above else link
        near = link in bending and np.linalg.norm(poses[before][0] - poses[link][0]) < _HAND
        return first(before) if near and before != link else link

    found = [(first(anchor(above[link])), link) for link in sorted(bending) if first(link) == link]
    return [*found, (first(anchor(description.tip.link)), "")]


@functools.lru_cache(maxsize=32)
def _solver(robot: Robot, elevation: bool, turned: bool, apart: bool) -> tuple[ca.Function, int]:
    """The program, and how many distances it keeps.

    Parameters: tip, sine of elevation, the tool's axes column by column, near, psi.
    """
    nq, nv = robot.n_joints, robot.n_vectoring
    q, p = ca.SX.sym("q", nq), ca.SX.sym("p", 13 + nq + nv)
    tip, axes, points, _ = _geometry(robot)(q, p[13 + nq :])
    rows: list[Any] = [tip - p[:3]]
    if elevation:
        rows.append(axes[2, 0] - p[3])
    if turned:
        # Three products of two axes are zero in four orientations; two more, above zero, leave one of them.
        seen = ca.reshape(p[4:13], 3, 3).T @ axes
        rows += [seen[1, 0], seen[2, 0], seen[2, 1], seen[0, 0], seen[1, 1]]
    pairs = _pairs(_segments(robot)) if apart else []
    rows += [ca.sumsqr(points[:, i] - points[:, j]) for i, j in pairs]
    problem = {"x": q, "p": p, "f": ca.sumsqr(q - p[13 : 13 + nq]), "g": ca.vertcat(*rows)}
    return ipopt(problem, _ITERATIONS), len(pairs)


def link_distances(robot: Robot, joint_angles: Any) -> Any:
    """Distances between points of links that are not joined, m, (k, 1), of CasADi's joint angles (nq,)."""
    psi = ca.DM(robot.description.vectoring_start)
    points = _geometry(robot)(joint_angles, psi)[2]
    rows = [ca.norm_2(points[:, i] - points[:, j]) for i, j in _pairs(_segments(robot))]
    return ca.vertcat(*rows)


def _pairs(segments: list[tuple[str, str]]) -> list[tuple[int, int]]:
    """Indices of points on links that have no end in common."""
    n = len(_SHARES)
    return [
        (n * a + i, n * b + j)
        for a in range(len(segments))
        for b in range(a + 1, len(segments))
        if not set(segments[a]) & set(segments[b])
        for i in range(n)
        for j in range(n)
    ]
