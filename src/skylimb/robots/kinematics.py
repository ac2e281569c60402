"""Poses of bodies and composite mass properties as CasADi expressions, kept small.

Joint axes of this class of robots are parallel. A chain of turns about parallel axes is one turn by the sum
of the angles, so a body's orientation is written Rot(axis, angle) R_zero with a constant R_zero: one sine and
cosine a body, and constant entries stay constant. A joint whose axis is not parallel to those above it starts
a new axis, at the cost of a longer expression.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from skylimb.base.rotations import hat
from skylimb.robots.bodies import Body
from skylimb.robots.urdf import clean_rotation

Array = Any
"""A CasADi matrix."""

Z_AXIS = np.array([0.0, 0.0, 1.0])

_NOTHING = 1e-16
"""A second moment (kg m^2) that is a rounding error: dropped, so that no operation is spent on it."""


@dataclass(frozen=True)
class BodyPose:
    """Pose of a body in the root frame: R = base Rot(axis, angle) R_zero.

    Attributes:
        xyz: 3 x 1 origin, m.
        base: 3 x 3 turn by joints whose axes are not parallel to `axis`, None when there are none.
        axis: (3,) constant unit vector.
        angle: turn about it, rad.
        R_zero: (3, 3) constant.
        turn: 3 x 3 expression, base Rot(axis, angle).
    """

    xyz: Array
    base: Array | None
    axis: np.ndarray
    angle: Any
    R_zero: np.ndarray
    turn: Array

    def turned(self, constant: np.ndarray) -> Array:
        """Orientation (or vector) `constant` of the body's frame, in root axes."""
        return self.turn @ _sparse(self.R_zero @ constant)

    def point(self, xyz: np.ndarray) -> Array:
        """A point of the body's frame, in the root frame."""
        return self.xyz + self.turned(np.asarray(xyz, dtype=float))


def _sparse(constant: np.ndarray) -> ca.SX:
    """A constant whose exact zeros are structural, so that no operation is spent on them."""
    return ca.SX(ca.sparsify(ca.DM(constant)))


def _turn(axis: np.ndarray, angle: Any) -> ca.SX:
    """Rot(axis, angle) with its constant, cosine and sine parts apart, so that zeros of each part vanish."""
    along = np.outer(axis, axis)
    return _sparse(along) + _sparse(np.eye(3) - along) * ca.cos(angle) + _sparse(hat(axis)) * ca.sin(angle)


def body_poses(bodies: Sequence[Body], angles: Mapping[str, Any]) -> list[BodyPose]:
    """The pose of every body in the root frame.

    Args:
        bodies: parents first; the root body's frame is the root frame.
        angles: joint name -> angle (an SX scalar), rad.
    """
    poses = [BodyPose(ca.SX(3, 1), None, Z_AXIS, 0.0, np.eye(3), ca.SX.eye(3))]
    for body in bodies[1:]:
        parent, joint = poses[body.parent], body.joint
        assert joint is not None  # only the root has none
        xyz = parent.xyz + parent.turned(body.xyz)
        R_zero = clean_rotation(parent.R_zero @ body.R)
        axis = clean_rotation(R_zero @ joint.axis)
        along = float(np.dot(axis, parent.axis))
        if abs(along) > 1.0 - 1e-12:
            base, axis, angle = parent.base, parent.axis, parent.angle + round(along) * angles[joint.name]
        else:
            base, axis, angle = parent.turn @ _sparse(R_zero), joint.axis, angles[joint.name]
            R_zero = np.eye(3)
        turn = _turn(axis, angle) if base is None else base @ _turn(axis, angle)
        poses.append(BodyPose(xyz, base, axis, angle, R_zero, turn))
    return poses


def joint_axis(body: Body, pose: BodyPose) -> Array:
    """Axis of the joint that carries a body, in root axes; zero for the root."""
    return pose.turned(body.joint.axis) if body.joint else ca.SX(3, 1)


def angular_velocities(
    bodies: Sequence[Body], poses: Sequence[BodyPose], root: Array, rates: Mapping[str, Any]
) -> list[Array]:
    """Angular velocity of every body in root axes, rad/s.

    Args:
        bodies: parents first.
        poses: of each.
        root: angular velocity of the root.
        rates: joint name -> rate, rad/s.
    """
    turns = [root]
    for body, pose in zip(bodies[1:], poses[1:], strict=True):
        rate = rates[body.joint.name] if body.joint else 0.0
        turns.append(turns[body.parent] + joint_axis(body, pose) * rate)
    return turns


def composite(bodies: Sequence[Body], poses: Sequence[BodyPose]) -> tuple[Array, Array]:
    """Centre of gravity in the root frame and inertia about it in root axes.

    The sums run over second moments S = integral of x x^T dm, which add up and shift more cheaply than
    inertias; I = trace(S) E - S at the end.
    """
    mass = sum(body.mass for body in bodies)
    centres = [pose.point(body.com) for body, pose in zip(bodies, poses, strict=True)]
    cog = sum((body.mass / mass * centre for body, centre in zip(bodies, centres, strict=True)), ca.SX(3, 1))
    moments = _symmetric(lambda i, j: 0)
    for body, pose, centre in zip(bodies, poses, centres, strict=True):
        S = pose.R_zero @ (0.5 * np.trace(body.inertia) * np.eye(3) - body.inertia) @ pose.R_zero.T
        d = centre - cog
        weighted = body.mass * d
        moments += _turned_moments(pose, S) + _symmetric(lambda i, j, d=d, w=weighted: w[i] * d[j])
    return cog, ca.trace(moments) * ca.SX.eye(3) - moments


def _symmetric(entry: Callable[[int, int], Any]) -> ca.SX:
    """A symmetric matrix from its upper triangle, so that each entry is computed once."""
    upper = {(i, j): entry(i, j) for i in range(3) for j in range(i, 3)}
    return ca.vertcat(*(ca.horzcat(*(upper[min(i, j), max(i, j)] for j in range(3))) for i in range(3)))


def _turned_moments(pose: BodyPose, S: np.ndarray) -> ca.SX:
    """Rot S Rot^T for a constant symmetric S.

    With Rot = P + c E + s K the product is a constant plus terms in the sine and cosine of the angle and of
    its double; most entries of their constant factors are zero, and those that remain cost one product each.
    """
    P = np.outer(pose.axis, pose.axis)
    E, K = np.eye(3) - P, hat(pose.axis)
    c, s = ca.cos(pose.angle), ca.sin(pose.angle)
    across, turned = E @ S @ E, K @ S @ K.T
    terms = [
        (ca.SX(1), P @ S @ P + 0.5 * (across + turned)),
        (c, P @ S @ E + E @ S @ P),
        (s, P @ S @ K.T + K @ S @ P),
        (c * c - s * s, 0.5 * (across - turned)),
        (2.0 * c * s, 0.5 * (E @ S @ K.T + K @ S @ E)),
    ]
    kept = [(factor, np.where(np.abs(part) < _NOTHING, 0.0, part)) for factor, part in terms]
    total = _symmetric(lambda i, j: sum(factor * part[i, j] for factor, part in kept if part[i, j] != 0.0))
    return total if pose.base is None else congruence(pose.base, total)


def congruence(R: Array, S: Array) -> ca.SX:
    """R S R^T for a symmetric S, each entry computed once."""
    half = R @ S
    return _symmetric(lambda i, j: sum(half[i, k] * R[j, k] for k in range(3)))
