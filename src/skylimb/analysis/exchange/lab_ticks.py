"""What a tick holds of which the lab's messages are made, and how the lab calls joints and frames."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from skylimb.analysis.exchange.body import Body
from skylimb.analysis.exchange.messages import Vector
from skylimb.base.rotations import hat
from skylimb.robots.links import Joint
from skylimb.robots.model import Robot

Placed = tuple[np.ndarray, np.ndarray]
"""A place, m, (3,), and axes, (3, 3)."""

Frame = tuple[str, str, np.ndarray, np.ndarray]
"""Parent and child, and the child's place, m, (3,), and axes, (3, 3), in the parent."""

UNKNOWN = (np.nan, np.nan, np.nan)
"""A vector that nobody knows."""


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
        self.mass = sum(link.inertial.mass for link in description.links)
        self.gimbals = tuple(name.replace("gimbal_joint", "gimbal") for name in description.vectoring_joints)
        turning = (*description.shape_joints, *description.vectoring_joints)
        self._places = [_Place(joint, turning, self) for joint in description.joints]

    def frame(self, name: str) -> str:
        """A frame of the robot, as the lab calls it."""
        return f"{self._namespace}/{name}"

    def link(self, name: str) -> str:
        """The frame of one of its links."""
        return f"{self._namespace}/{name}"

    @property
    def children(self) -> set[str]:
        """Frames of all links but the first."""
        return {place.child for place in self._places}

    def links(self, angles: np.ndarray, *, moving: bool | None = None) -> Iterator[Frame]:
        """Links in their parents.

        Args:
            angles: of joints and gimbals, rad.
            moving: only those whose joint moves, or only those whose joint never does.
        """
        for place in self._places:
            if moving is None or moving == (place.index is not None):
                yield place.parent, place.child, place.xyz, place.axes(angles)

    def root(self, angles: np.ndarray, measured: Placed) -> tuple[str, np.ndarray, np.ndarray]:
        """The first link of the URDF in W, from the measured link's pose there."""
        first = self.link(self._description.root)
        poses: dict[str, Placed] = {first: (np.zeros(3), np.eye(3))}
        for parent, child, place, R in self.links(angles):
            there, axes = poses[parent]
            poses[child] = there + axes @ place, axes @ R
        there, axes = poses[self.link(self._description.measured_link)]
        R = measured[1] @ axes.T
        return first, measured[0] - R @ there, R

    def fixed(self, angles: np.ndarray) -> Iterator[Frame]:
        """Frames that never move in their parents: the first link is the lab's root."""
        yield self.frame("root"), self.link(self._description.root), np.zeros(3), np.eye(3)
        yield from self.links(angles, moving=False)


class _Place:
    """A link in its parent: R(angle) = R_0 + sin(angle) R_1 + (1 - cos(angle)) R_2 (Rodrigues' formula).

    Args:
        joint: that it turns with.
        turning: joints that turn, in the order of their angles.
        names: of the frames.
    """

    def __init__(self, joint: Joint, turning: Sequence[str], names: Names) -> None:
        self.parent, self.child, self.xyz = names.link(joint.parent), names.link(joint.child), joint.xyz
        self.index = turning.index(joint.name) if joint.name in turning else None
        K = hat(np.asarray(joint.axis, dtype=float))
        self._parts = joint.R, joint.R @ K, joint.R @ K @ K

    def axes(self, angles: np.ndarray) -> np.ndarray:
        """Its axes in its parent, (3, 3)."""
        fixed, sine, cosine = self._parts
        if self.index is None:
            return fixed
        angle = float(angles[self.index])
        return fixed + math.sin(angle) * sine + (1.0 - math.cos(angle)) * cosine


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
