"""Where the parts of a robot are that pictures of a posture show."""

from __future__ import annotations

import numpy as np

from skylimb.robots.extent import rim
from skylimb.robots.model import Robot


def outline(
    robot: Robot, joint_angles: np.ndarray, vectoring_angles: np.ndarray
) -> tuple[np.ndarray, list[tuple[np.ndarray, np.ndarray, np.ndarray]]]:
    """The chain of links, (k, 3), and middle (3,), axis (3,) and rim (k, 3) of each rotor; root axes, m."""
    poses = robot.link_poses(joint_angles, vectoring_angles)
    placed = [(poses[rotor.link], rotor) for rotor in robot.description.rotors]
    rotors = [
        (origin + R @ rotor.xyz, R @ rotor.R[:, 2], origin + rim(rotor) @ R.T)
        for (origin, R), rotor in placed
    ]
    return np.array(robot.skeleton(joint_angles, vectoring_angles)), rotors
