"""Poses of another link than the measured one: the lab's motion capture shows its flight controller."""

from __future__ import annotations

import numpy as np

from skylimb.base.errors import unknown_name
from skylimb.base.rotations import rot_z
from skylimb.robots.model import Robot

LAB = "flight_controller"
"""The link whose pose is on the lab's topics, where a robot has it."""


def lab_link(robot: Robot, name: str = "") -> str:
    """The link whose pose is on the lab's topics: the one that is named, else the flight controller.

    Raises:
        UnknownNameError: when the robot has no link of that name.
    """
    links = [link.name for link in robot.description.links]
    if name and name not in links:
        raise unknown_name(f"link of {robot.name}", name, links)
    return name or (LAB if LAB in links else robot.description.measured_link)


def lab_turn_in_C(
    robot: Robot, link: str, joint_angles: np.ndarray, vectoring_angles: np.ndarray
) -> np.ndarray:
    """The lab's axes at the centre of gravity, in C: level like C, with the yaw of the lab's link, (3, 3)."""
    _, turn = from_measured_link(robot, link, joint_angles, vectoring_angles)
    R = robot.at(joint_angles, vectoring_angles).R_root_C.T @ turn
    return np.asarray(rot_z(np.arctan2(R[1, 0], R[0, 0])))


def from_measured_link(
    robot: Robot, link: str, joint_angles: np.ndarray, vectoring_angles: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Position (3,), m, and orientation (3, 3) of a link seen from the measured link."""
    poses = robot.link_poses(joint_angles, vectoring_angles)
    (base, turn), (xyz, R) = poses[robot.description.measured_link], poses[link]
    return turn.T @ (xyz - base), turn.T @ R
