"""What a tick holds of which the lab's messages are made, and how the lab calls joints and frames."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from skylimb.analysis.exchange.body import Body
from skylimb.analysis.exchange.messages import Vector
from skylimb.base.rotations import rotation_from_axis_angle
from skylimb.robots.model import Robot

Placed = tuple[np.ndarray, np.ndarray]
"""A place, m, (3,), and axes, (3, 3)."""

Frame = tuple[str, str, np.ndarray, np.ndarray]
"""Parent and child, and the child's place, m, (3,), and axes, (3, 3), in the parent."""

UNKNOWN = (np.nan, np.nan, np.nan)
"""A vector that nobody knows."""


def lab_name(joint: str) -> str:
    """A joint as the lab calls it: our `gimbal_joint1` is its `gimbal1`."""
    return joint.replace("gimbal_joint", "gimbal")


class Names:
    """Names of a robot's joints and frames on the lab's topics.

    Args:
        robot: whose. Our `gimbal_jointN` is the lab's `gimbalN`, with the same zero and axis.
        namespace: of the lab's topics, and of its frames.

    Attributes:
        mass: of the whole robot, kg.
    """

    def __init__(self, robot: Robot, namespace: str = "hydrus_xi") -> None:
        description, self._namespace = robot.description, namespace.strip("/")
        self._description = description
        self.joints = description.shape_joints
        self.mass = description.mass
        self.gimbals = tuple(map(lab_name, description.vectoring_joints))

    def frame(self, name: str) -> str:
        """A frame of the robot, as the lab calls it."""
        return f"{self._namespace}/{name}"

    def link(self, name: str) -> str:
        """The frame of one of its links."""
        return f"{self._namespace}/{name}"

    @functools.cached_property
    def children(self) -> frozenset[str]:
        """Frames of all links but the first."""
        return frozenset(self.link(joint.child) for joint in self._description.joints)

    def links(self, angles: np.ndarray) -> Iterator[tuple[bool, Frame]]:
        """Links in their parents, each behind whether its joint moves; angles of joints and gimbals, rad."""
        turning = (*self._description.shape_joints, *self._description.vectoring_joints)
        known = dict(zip(turning, angles, strict=True))
        for joint in self._description.joints:
            turns = joint.name in known
            R = joint.R
            if turns:
                R = np.asarray(R @ rotation_from_axis_angle(joint.axis, known[joint.name]))
            yield turns, (self.link(joint.parent), self.link(joint.child), joint.xyz, R)

    def placed(self, angles: np.ndarray, measured: Placed) -> tuple[str, Placed, list[Frame]]:
        """The first link of the URDF, its pose in W, and the links that move in their parents.

        Args:
            angles: of joints and gimbals, rad.
            measured: pose of the measured link in W.
        """
        first, moving = self.link(self._description.root), list[Frame]()
        wanted = self.link(self._description.measured_link)
        poses: dict[str, Placed] = {first: (np.zeros(3), np.eye(3))}
        for turns, frame in self.links(angles):
            parent, child, place, R = frame
            if wanted not in poses:
                there, axes = poses[parent]
                poses[child] = there + axes @ place, axes @ R
            if turns:
                moving.append(frame)
        there, axes = poses[wanted]
        R = measured[1] @ axes.T
        return first, (measured[0] - R @ there, R), moving

    def fixed(self, angles: np.ndarray) -> Iterator[Frame]:
        """Frames that never move in their parents: the first link is the lab's root."""
        yield self.frame("root"), self.link(self._description.root), np.zeros(3), np.eye(3)
        yield from (frame for turns, frame in self.links(angles) if not turns)


@dataclass(frozen=True)
class TickView:
    """What a tick holds of which messages are made; what is not known is None, or NaN.

    Attributes:
        stamp: s.
        names: of joints and frames.
        body: centre of gravity and the lab's link as measured.
        angles: joints and gimbals as measured, rad.
        command: thrusts, N, joint and vectoring angles, rad.
        motors: whether the thrusts mean anything.
        signals: of a controller or a log, by name.
        cog: position, velocity, attitude and rates of C, where they are not the body's.
        felt: rates (rad/s) and specific force (m/s^2) of the flight controller's IMU in the axes of the lab's
            link.
        magnetic_field: that its compass shows.
        attitude: that it believes its axes to have, where it is not the body's, (3, 3).
        state: the byte of `flight_state`.
        arming: what the flight controller is commanded.
        target: position and velocity of the reference, W, (3,) each, and the yaw of the lab's link, rad.
    """

    stamp: float
    names: Names
    body: Body | None = None
    angles: np.ndarray | None = None
    command: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None
    motors: bool = True
    signals: Mapping[str, Any] = field(default_factory=dict)
    cog: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray] | None = None
    felt: tuple[np.ndarray, np.ndarray] | None = None
    magnetic_field: Vector = UNKNOWN
    attitude: np.ndarray | None = None
    state: int | None = None
    arming: int | None = None
    target: tuple[np.ndarray, np.ndarray, float] | None = None
