"""What a robot is: bodies, joints, rotors, servos and the tip, as its files say.

Records with arrays compare by identity: whether two robots are the same is what their digests tell.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.base.sources import Source
from skylimb.robots.links import Fixed, Joint, Link, zeros

GRAVITY = 9.80665
"""Standard gravity, m/s^2: that of every place that an experiment does not say otherwise."""
AIR_DENSITY = 1.225
"""Of air at sea level (ISO 2533), kg/m^3."""

_Each = float | tuple[float, ...]
"""One number for every joint, or one for each."""


@configuration
class Servo:
    """Position servos: torque = stiffness * error - damping * speed. A number for all, or [one for each]."""

    stiffness: Annotated[_Each, Key("N m/rad", "torque per error", above=0.0, high=1e6)]
    damping: Annotated[_Each, Key("N m s/rad", "torque per speed", low=0.0, high=1e5)]
    torque_limit: Annotated[_Each, Key("N m", "greatest torque", above=0.0, high=1e5)]
    speed_limit: Annotated[_Each, Key("rad/s", "speed of the set point it follows", above=0.0, high=1e3)]


NO_SERVO = Servo(1.0, 0.0, 1.0, 1.0)
"""Stands for the servo where there is no joint of a kind."""


@dataclass(frozen=True, eq=False)
class Servos(Fixed):
    """The servos of some joints, (n,) each: see `Servo`.

    Attributes:
        stiffness: N m/rad.
        damping: N m s/rad.
        torque_limit: N m.
        speed_limit: rad/s.
    """

    stiffness: np.ndarray
    damping: np.ndarray
    torque_limit: np.ndarray
    speed_limit: np.ndarray


@dataclass(frozen=True)
class Side:
    """What gives the thrust to the side of a pair in a motor's place: a servo that turns the rotor.

    Attributes:
        of: number of the rotor along; the speed of both is its own.
        lag: time constant of the servo, s.
    """

    of: int
    lag: float


@dataclass(frozen=True, eq=False)
class Rotor(Fixed):
    """A rotor and its frame {F_i}, whose z axis is the direction of thrust.

    Attributes:
        link: the link that {F_i} is fixed to.
        xyz: (3,) origin of {F_i} in that link's frame, m.
        R: (3, 3) orientation of {F_i} in that link's frame.
        spin: +1 when it turns about +z, -1 about -z.
        drag_torque_coefficient: signed kappa_i of eq:allocation for torque, m; its sign is against the spin.
        thrust_min: least thrust, N.
        thrust_max: greatest thrust, N.
        lag: time constant of the thrust, and of the speed, s.
        thrust_factor: thrust over squared speed, N s^2; None where the file does not say.
        inertia: of all that turns, about its axis, kg m^2; None where the file does not say.
        torque_max: greatest torque of the motor, driving and braking, N m.
        radius: of its disc, m; None where neither the file nor a drawn propeller says it.
        side: of a pair, where it is the side (`robots.turned_rotors`); None for a rotor with a motor.
    """

    name: str
    link: str
    xyz: np.ndarray
    R: np.ndarray
    spin: int
    drag_torque_coefficient: float
    thrust_min: float
    thrust_max: float
    lag: float
    thrust_factor: float | None = None
    inertia: float | None = None
    torque_max: float = math.inf
    radius: float | None = None
    side: Side | None = None


@dataclass(frozen=True, eq=False)
class Tip(Fixed):
    """The tool: a frame at the middle of a small ball that touches, on a link.

    Attributes:
        link: that carries it.
        position: (3,) of the ball's middle in the link's frame, m.
        radius: of the ball, m.
        stem: (3,) where a drawn stick that carries it begins, in the link's frame, m, or None.
        heading: whose x axis, seen from above, is the heading: the tool's or the root's.
        R: (3, 3) orientation of the tool in the link's frame; its x axis points out.
    """

    link: str
    position: np.ndarray
    radius: float
    stem: np.ndarray | None = None
    heading: Literal["tool", "root"] = "tool"
    R: np.ndarray = field(default_factory=lambda: np.eye(3))

    @property
    def along(self) -> np.ndarray:
        """Along a pen or peg and out of the robot, axes of the link, (3,): its stem, or x of the tool."""
        if self.stem is None:
            return self.R[:, 0]
        stem = self.position - self.stem
        return stem / np.linalg.norm(stem)


@dataclass(frozen=True, eq=False)
class Mount(Fixed):
    """Where a sensor sits: origin (m) and axes in the frame of a link."""

    link: str
    xyz: np.ndarray = field(default_factory=zeros)
    R: np.ndarray = field(default_factory=lambda: np.eye(3))


@dataclass(frozen=True, eq=False)
class PostureFamily(Fixed):
    """Postures with one parameter, the shape angle: q = offset + slope * theta (eq:joint angles), in rad."""

    offset: np.ndarray
    slope: np.ndarray
    theta_min: float
    theta_max: float
    theta_nominal: float
    contact_side: Literal["same", "mirrored"] = "same"

    @property
    def nominal(self) -> np.ndarray:
        """Joint angles of the nominal shape angle, rad."""
        return self.offset + self.slope * self.theta_nominal


@dataclass(frozen=True, eq=False)
class RobotDescription(Fixed):
    """Everything that the files say about a robot.

    Attributes:
        name: short name.
        summary: one line for people.
        root: the URDF's root link; its frame is the root frame.
        links: all links, parents before children.
        joints: all joints, in the same order as the links they lead to.
        rotors: in the order of the thrust vector.
        shape_joints: joint names, in the order of the joint angles q.
        vectoring_joints: joint names, in the order of the vectoring angles psi.
        shape_servos: those of the shape joints.
        vectoring_servos: those of the vectoring joints.
        vectoring_start: (n_vectoring,) angles where the search for good vectoring angles begins, rad.
        tip: the contact point.
        posture: the one-parameter family of postures.
        measured_link: the link whose pose and twist are measured.
        digest: SHA-256 of the two files, hexadecimal.
        folder: where the files are.
        sources: the flight TOML and the URDF as they were read.
        gravity: of the place where it flies, m/s^2.
        imu_mount: where the file says that the IMU is; None where it does not (`imu`).
        preferred_thrusts: that hover comes nearest to, N, (n,); None for the least (`flight_check.bounded`).
    """

    name: str
    summary: str
    root: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    rotors: tuple[Rotor, ...]
    shape_joints: tuple[str, ...]
    vectoring_joints: tuple[str, ...]
    shape_servos: Servos
    vectoring_servos: Servos
    vectoring_start: np.ndarray
    tip: Tip
    posture: PostureFamily
    measured_link: str
    digest: str
    folder: Path
    sources: tuple[Source, ...] = ()
    gravity: float = GRAVITY
    imu_mount: Mount | None = None
    preferred_thrusts: np.ndarray | None = None

    @property
    def imu(self) -> Mount:
        """Where the IMU is; at the measured link's origin, in its axes, where the file does not say."""
        return self.imu_mount or Mount(self.measured_link)

    @property
    def moving_joints(self) -> tuple[str, ...]:
        """Names of the shape joints, then of the vectoring joints: the order of all angles together."""
        return (*self.shape_joints, *self.vectoring_joints)

    @property
    def servos(self) -> Servos:
        """Those of the moving joints, in that order."""
        shape, vectoring = vars(self.shape_servos), vars(self.vectoring_servos)
        return Servos(**{key: np.concatenate([shape[key], vectoring[key]]) for key in shape})

    @property
    def mass(self) -> float:
        """Of all links together, kg."""
        return sum(link.inertial.mass for link in self.links)

    def link(self, name: str) -> Link:
        """The link of that name."""
        return next(link for link in self.links if link.name == name)

    def joint(self, name: str) -> Joint:
        """The joint of that name."""
        return next(joint for joint in self.joints if joint.name == name)
