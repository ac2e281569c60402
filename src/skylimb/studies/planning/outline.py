"""Where the parts of a robot are that pictures of a posture show."""

from __future__ import annotations

import numpy as np

from skylimb.robots.model import Robot

_AROUND = np.linspace(0.0, 2.0 * np.pi, 40)

DISC = 0.12 * np.array([np.cos(_AROUND), np.sin(_AROUND), 0.0 * _AROUND])
"""A rotor as it is drawn, in its own axes, m, (3, k)."""


def outline(
    robot: Robot, joint_angles: np.ndarray, vectoring_angles: np.ndarray
) -> tuple[np.ndarray, list[tuple[np.ndarray, np.ndarray]]]:
    """The chain of links, (k, 3), and place (3,) and axes (3, 3) of each rotor; root link's axes, m."""
    poses = robot.link_poses(joint_angles, vectoring_angles)
    placed = [(poses[rotor.link], rotor) for rotor in robot.description.rotors]
    rotors = [(origin + R @ rotor.xyz, R @ rotor.R) for (origin, R), rotor in placed]
    return np.array(robot.skeleton(joint_angles, vectoring_angles)), rotors
