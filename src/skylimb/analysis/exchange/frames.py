"""Poses of another link than the measured one: the lab's motion capture shows its flight controller."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from skylimb.base.bound_function import ArrayFunction
from skylimb.base.errors import unknown_name
from skylimb.base.rotations import rpy_from_rotation
from skylimb.robots.model import Robot


def lab_link(robot: Robot, name: str = "") -> str:
    """The link whose pose is on the lab's topics: the one that is named, else the IMU's.

    Raises:
        UnknownNameError: when the robot has no link of that name.
    """
    links = [link.name for link in robot.description.links]
    if name and name not in links:
        raise unknown_name(f"link of {robot.name}", name, links)
    return name or robot.description.imu.link


def felt_by(robot: Robot, link: str, imu: Sequence[Any] | None) -> tuple[Any, Any] | None:
    """What an IMU says in the axes of its link; None where it sits on another than `link`."""
    mount = robot.description.imu
    return None if imu is None or mount.link != link else (mount.R @ imu[0], mount.R @ imu[1])


class LinkFrames(NamedTuple):
    """Centre of gravity and the lab's link of a posture, seen from the measured link.

    Attributes:
        cog: centre of gravity, m, (3,).
        R_root_C: axes of C, (3, 3).
        tip_heading: the heading (of tool or root) in C, rad.
        link: origin of the lab's link, m, (3,).
        R_root_link: its axes, (3, 3).
    """

    cog: np.ndarray
    R_root_C: np.ndarray
    tip_heading: float
    link: np.ndarray
    R_root_link: np.ndarray

    @property
    def yaw_in_C(self) -> float:
        """Yaw of the lab's link in C, rad."""
        return float(rpy_from_rotation(self.R_root_C.T @ self.R_root_link)[2])


def frames_function(robot: Robot, link: str) -> ca.Function:
    """(q, psi) -> the entries of `LinkFrames`, in numbers or symbols.

    Args:
        robot: whose.
        link: whose pose is on the lab's topics.
    """
    q, psi = ca.SX.sym("q", robot.n_joints), ca.SX.sym("psi", robot.n_vectoring)
    model: Any = robot.model(q, psi)
    there: Any = robot.link_pose_function(link)(q, psi)
    base: Any = robot.link_pose_function(robot.description.measured_link)(q, psi)
    turn = base[:, 1:].T
    link_pose = (turn @ (there[:, 0] - base[:, 0]), turn @ there[:, 1:])
    outputs = [ca.densify(part) for part in (model.cog_root, model.R_root_C, model.tip_heading, *link_pose)]
    return ca.Function("link_frames", [q, psi], outputs, {"cse": True})


class Frames:
    """The frames of any posture, in numbers; arguments are those of `frames_function`."""

    def __init__(self, robot: Robot, link: str) -> None:
        self._function = ArrayFunction(frames_function(robot, link))

    def at(self, joint_angles: np.ndarray, vectoring_angles: np.ndarray) -> LinkFrames:
        """Those of joint and vectoring angles, rad."""
        cog, R_root_C, heading, link, R = self._function(joint_angles, vectoring_angles)
        return LinkFrames(cog, R_root_C, float(heading[0]), link, R)
