"""Can it touch? Whether the tip is what comes first to a surface, clear of links and rotors."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from skylimb.base.rotations import rot_z
from skylimb.robots.description import RobotDescription
from skylimb.robots.extent import Part, parts_of
from skylimb.robots.model import Robot


@dataclass(frozen=True, eq=False)
class Touch:
    """How the tip stands to the rest of the robot, seen along a direction.

    Attributes:
        direction: in the level frame whose x axis is the heading, unit, (3,).
        room: how far the tip is before the foremost rotor's disc, or link's shape or origin, m; 0 or less
            where it is not foremost.
        nearest: the name of that rotor or link.
    """

    direction: np.ndarray
    room: float
    nearest: str

    def __bool__(self) -> bool:
        return self.room > 0.0

    def __str__(self) -> str:
        way = ", ".join(f"{part:.2f}" for part in self.direction)
        if self:
            return f"the tip is foremost along ({way}), {self.room:.3g} m before '{self.nearest}'"
        return f"'{self.nearest}' is {-self.room:.3g} m before the tip along ({way})"


def can_touch(
    robot: Robot,
    joint_angles: np.ndarray,
    vectoring_angles: np.ndarray,
    direction: np.ndarray | None = None,
) -> Touch:
    """How far the tip is before all else.

    Args:
        robot: level.
        joint_angles: q, rad, (nq,).
        vectoring_angles: psi, rad, (nv,).
        direction: in the level frame whose x axis is the heading, unit; by default the one in which the
            tip is foremost by most.
    """
    names, points, radii, tip = _places(robot, joint_angles, vectoring_angles)
    way = _most_foremost(points - tip) if direction is None else np.asarray(direction, dtype=float)
    rooms = (tip - points) @ way - radii
    nearest = int(np.argmin(rooms))
    return Touch(way, float(rooms[nearest]), names[nearest])


def _places(
    robot: Robot, joint_angles: np.ndarray, vectoring_angles: np.ndarray
) -> tuple[list[str], np.ndarray, np.ndarray, np.ndarray]:
    """Names, places and radii of what may be foremost, and the tip's place, m."""
    poses = robot.link_poses(joint_angles, vectoring_angles)
    parts, names, radii = _foremost_parts(robot.description)
    placed = [poses[part.link][0] + part.points @ poses[part.link][1].T for part in parts]
    tool, heading = robot.tool(joint_angles, vectoring_angles)
    level = rot_z(-heading)
    return names, np.concatenate(placed) @ level.T, radii, level @ tool[:, 0]


@functools.lru_cache(maxsize=16)
def _foremost_parts(description: RobotDescription) -> tuple[list[Part], list[str], np.ndarray]:
    """What may be foremost in any posture; the name and the radius of each of their points."""
    # A search for a posture asks this of one robot some thousand times.
    bending = [description.root, *(description.joint(name).child for name in description.shape_joints)]
    parts = [*(Part(name, name, np.zeros((1, 3))) for name in bending), *parts_of(description)]
    names = [part.name for part in parts for _ in part.points]
    return parts, names, np.repeat([part.radius for part in parts], [len(part.points) for part in parts])


def _most_foremost(points: np.ndarray) -> np.ndarray:
    """The direction from the nearest point of the points' convex hull to zero; x where zero is inside."""
    from scipy.optimize import nnls  # slow to import

    # Weights w >= 0 of sum 1 with the least |sum w_i x_i|; the sum is kept by its own heavy row.
    heavy = 1e3 * (1.0 + float(np.abs(points).max()))
    weights, _ = nnls(np.vstack([points.T, heavy * np.ones(len(points))]), np.array([0.0, 0.0, 0.0, heavy]))
    nearest = weights @ points / weights.sum()
    size = float(np.linalg.norm(nearest))
    return -nearest / size if size > 1e-6 else np.array([1.0, 0.0, 0.0])
