"""Planar inverse kinematics: joint angles that put the tip at a point with the tip link at a heading."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from skylimb.errors import ConfigError, DescriptionError, UnreachableError
from skylimb.robots import Robot
from skylimb.spatial import wrapped

_SLACK = 1e-9
_TOLERANCE = 1e-10


@dataclass(frozen=True)
class PlanarChain:
    """The chain from the root link to the tip, seen along z.

    Attributes:
        root: (2,) first joint in the root frame, m.
        segments: (nq, 2) from each joint to the next and from the last to the tip, at joint angles zero, root
            axes, m.
        signs: (nq,) +1 where the joint's axis is +z of the root frame, -1 where it is -z.
        heading: of the tip link's x axis at joint angles zero, rad.
    """

    root: np.ndarray
    segments: np.ndarray
    signs: np.ndarray
    heading: float

    def forward(self, joint_angles: np.ndarray) -> tuple[np.ndarray, float]:
        """Tip (2,) in m and heading in rad, both in the root frame."""
        turns = np.cumsum(self.signs * joint_angles)
        along = self.segments[:, 0] + 1j * self.segments[:, 1]
        tip = np.sum(along * np.exp(1j * turns))
        return self.root + np.array([tip.real, tip.imag]), self.heading + float(turns[-1])

    def jacobian(self, joint_angles: np.ndarray) -> np.ndarray:
        """(3, nq): derivative of tip and heading by the joint angles."""
        turns = np.cumsum(self.signs * joint_angles)
        steps = (self.segments[:, 0] + 1j * self.segments[:, 1]) * np.exp(1j * turns)
        lever = 1j * np.cumsum(steps[::-1])[::-1] * self.signs
        return np.vstack([lever.real, lever.imag, self.signs])


def planar_chain(robot: Robot) -> PlanarChain:
    """The robot's planar chain.

    Raises:
        DescriptionError: the chain has an axis that is not along z, or joints that do not lead from root to
            tip.
    """
    description = robot.description
    zero = robot.link_poses(np.zeros(robot.n_joints), np.zeros(robot.n_vectoring))
    path, body = [], robot.bodies[robot.placements[description.tip.link].body]
    while body.joint is not None:
        path.insert(0, body.joint)
        body = robot.bodies[body.parent]
    if tuple(joint.name for joint in path) != description.shape_joints:
        raise DescriptionError(
            f"planar inverse kinematics of '{robot.name}' needs shape.joints to be the joints from root to "
            "tip, in that "
            f"order: {', '.join(joint.name for joint in path)}"
        )
    axes = [zero[joint.child][1] @ joint.axis for joint in path]
    for joint, axis in zip(path, axes, strict=True):
        if abs(abs(axis[2]) - 1.0) > _SLACK:
            raise DescriptionError(
                f"planar inverse kinematics needs joints about z; '{joint.name}' turns about {axis}"
            )
    position, R = zero[description.tip.link]
    points = np.array(
        [*(zero[joint.child][0][:2] for joint in path), (position + R @ description.tip.position)[:2]]
    )
    signs = np.array([math.copysign(1.0, axis[2]) for axis in axes])
    return PlanarChain(points[0], np.diff(points, axis=0), signs, math.atan2(R[1, 0], R[0, 0]))


def planar_inverse_kinematics(
    robot: Robot,
    position_xy: Sequence[float] | np.ndarray,
    heading: float,
    *,
    elbow: Literal["left", "right"] | None = None,
    near: Sequence[float] | np.ndarray | None = None,
) -> np.ndarray:
    """Joint angles that put the tip at a point of the plane with the tip link's x axis at a heading.

    Three joints are solved in closed form, with two solutions; longer chains numerically, for the solution
    closest to `near`.

    Args:
        robot: a robot whose shape joints turn about z and lead from root to tip.
        position_xy: (2,) tip in the root frame, m.
        heading: of the tip link's x axis in the root frame, rad; whole turns make no difference.
        elbow: for three joints, bend the second one to the "left" (turn about +z) or "right"; None takes the
            solution within the limits, and of two the one closer to `near`.
        near: (nq,) joint angles to stay close to, rad; zeros when not given.

    Returns:
        (nq,) joint angles within the joint limits, rad.

    Raises:
        UnreachableError: no joint angles within the limits do it.
        ConfigError: an argument of the wrong shape.
    """
    target = np.asarray(position_xy, dtype=float)
    close = np.zeros(robot.n_joints) if near is None else np.asarray(near, dtype=float)
    if target.shape != (2,) or not np.all(np.isfinite([*target, heading])):
        raise ConfigError(
            f"position_xy = {target.tolist()}, heading = {heading} must be two and one finite numbers"
        )
    if close.shape != (robot.n_joints,):
        raise ConfigError(f"near = {close.tolist()} must be {robot.n_joints} joint angles (rad)")
    if elbow not in (None, "left", "right"):
        raise ConfigError(f"elbow = {elbow!r} must be 'left', 'right' or None")
    chain = planar_chain(robot)
    wanted = f"tip at ({target[0]:.4g}, {target[1]:.4g}) m with heading {heading:.4g} rad"
    if robot.n_joints == 3:
        return _closed_form(robot, chain, target, heading, elbow, close, wanted)
    return _numeric(robot, chain, target, heading, close, wanted)


def _closed_form(
    robot: Robot,
    chain: PlanarChain,
    target: np.ndarray,
    heading: float,
    elbow: str | None,
    close: np.ndarray,
    wanted: str,
) -> np.ndarray:
    a, b, c = (complex(*segment) for segment in chain.segments)
    total = heading - chain.heading
    wrist = complex(*(target - chain.root)) - c * np.exp(1j * total)
    near_end, far_end = round(abs(abs(a) - abs(b)), 12), abs(a) + abs(b)
    if not near_end - _SLACK <= abs(wrist) <= far_end + _SLACK:
        raise UnreachableError(
            f"'{robot.name}' cannot reach {wanted}: its last joint would be {abs(wrist):.4g} m from its "
            "first, possible is "
            f"{near_end:.4g} .. {far_end:.4g} m"
        )
    cosine = (abs(wrist) ** 2 - abs(a) ** 2 - abs(b) ** 2) / (2.0 * abs(a) * abs(b))
    bend = math.acos(min(1.0, max(-1.0, cosine)))
    offset = np.angle(b) - np.angle(a)
    solutions = []
    for side in (bend, -bend):
        second = side - offset
        first = np.angle(wrist) - np.angle(a + b * np.exp(1j * second))
        turns = np.array([first, second, total - first - second])
        solutions.append(_wrapped(chain.signs * turns, robot, close))
    if elbow is not None:
        solutions = [solutions[0] if elbow == "left" else solutions[1]]
    allowed = [q for q in solutions if _inside(q, robot)]
    if not allowed:
        raise UnreachableError(f"'{robot.name}' cannot reach {wanted}: {_violation(solutions, robot)}")
    return min(allowed, key=lambda q: float(np.sum((q - close) ** 2)))


def _wrapped(q: np.ndarray, robot: Robot, close: np.ndarray) -> np.ndarray:
    """The same angles plus whole turns: within the limits where possible, then close to `close`."""
    lower, upper = robot.joint_limits()
    around = close + wrapped(q - close)
    around = np.where(around > upper + _SLACK, around - 2.0 * np.pi, around)
    around = np.where(around < lower - _SLACK, around + 2.0 * np.pi, around)
    around = np.where(around > upper + _SLACK, wrapped(q), around)
    return np.where(
        np.abs(around - np.clip(around, lower, upper)) <= _SLACK, np.clip(around, lower, upper), around
    )


def _inside(q: np.ndarray, robot: Robot) -> bool:
    lower, upper = robot.joint_limits()
    return bool(np.all((q >= lower) & (q <= upper)))


def _violation(solutions: Sequence[np.ndarray], robot: Robot) -> str:
    lower, upper = robot.joint_limits()
    over = [np.maximum(lower - q, q - upper) for q in solutions]
    best = min(range(len(solutions)), key=lambda k: float(np.max(over[k])))
    joint = int(np.argmax(over[best]))
    return (
        f"it needs {robot.description.shape_joints[joint]} at {solutions[best][joint]:.4g} rad, limits are "
        f"{lower[joint]:.4g} .. {upper[joint]:.4g} rad"
    )


def _numeric(
    robot: Robot, chain: PlanarChain, target: np.ndarray, heading: float, close: np.ndarray, wanted: str
) -> np.ndarray:
    from scipy.optimize import least_squares, minimize

    lower, upper = robot.joint_limits()
    lower, upper = np.maximum(lower, -np.pi), np.minimum(upper, np.pi)

    def error(q: np.ndarray) -> np.ndarray:
        tip, angle = chain.forward(q)
        return np.array([*(tip - target), wrapped(angle - heading)])

    def distance(q: np.ndarray) -> float:
        return float(np.sum((q - close) ** 2))

    def onto_target(start: np.ndarray) -> np.ndarray | None:
        # Active bounds are handled exactly, so that a solution at its limits is found as well.
        solution = least_squares(
            error,
            np.clip(start, lower, upper),
            jac=chain.jacobian,  # pyright: ignore[reportArgumentType]
            bounds=(lower, upper),
            method="dogbox",
            xtol=1e-15,
            ftol=1e-15,
            gtol=1e-15,
        )
        return solution.x if np.max(np.abs(error(solution.x))) < _TOLERANCE else None

    def nearer(start: np.ndarray) -> np.ndarray | None:
        solution = minimize(
            distance,
            start,
            jac=lambda q: 2.0 * (q - close),
            bounds=list(zip(lower, upper, strict=True)),
            constraints={"type": "eq", "fun": error, "jac": chain.jacobian},
            method="SLSQP",
            options={"maxiter": 100, "ftol": 1e-14},
        )
        return onto_target(solution.x)

    # Bends to either side, besides the wish itself: a straight chain is a saddle that no descent leaves.
    bends = [sign * size * np.ones(robot.n_joints) for size in (0.3, 0.9) for sign in (1.0, -1.0)]
    alternating = [sign * 0.6 * (-1.0) ** np.arange(robot.n_joints) for sign in (1.0, -1.0)]
    on_target = [q for start in [close, *bends, *alternating] if (q := onto_target(start)) is not None]
    if not on_target:
        raise UnreachableError(f"'{robot.name}' finds no joint angles within its limits for {wanted}")
    closest = min(on_target, key=distance)
    improved = [q for start in (close, closest) if (q := nearer(np.clip(start, lower, upper))) is not None]
    return min([*on_target, *improved], key=distance)
