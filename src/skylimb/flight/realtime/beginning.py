"""How far a robot is from where its mission begins: behind a link nobody leads it there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from skylimb.analysis.exchange.body import Body
from skylimb.base.rotations import rpy_from_rotation
from skylimb.control.estimation.records import Measurement
from skylimb.control.missions.reference import Reference
from skylimb.control.posture import heading_of
from skylimb.robots.model import Robot


class Beginning(NamedTuple):
    """A mission's beginning, and how far a robot is from it.

    Attributes:
        at: the centre of gravity there, W, m, (3,).
        yaw: of {C} there, rad.
        angles: of the shape joints there, rad, (nq,).
        place: way there, m.
        heading: turn there, rad.
        joints: greatest way of a shape joint, rad.
    """

    at: np.ndarray
    yaw: float
    angles: np.ndarray
    place: float
    heading: float
    joints: float


def beginning_of(robot: Robot, first: Reference, body: Body, measured: Measurement) -> Beginning:
    """How far a robot is from the first row of a mission.

    Args:
        robot: that flies it.
        first: that row.
        body: of the robot, as it was measured.
        measured: the same measurement: its joint angles.
    """
    q, psi = (np.asarray(part, dtype=float) for part in measured[4:6])
    at, angles = (np.asarray(part, dtype=float) for part in (first.position, first.joint_angles))
    wanted = float(heading_of(robot, robot.at(q, psi).tip_heading, first))
    turn = wanted - float(rpy_from_rotation(body.R_WC)[2])
    joints = float(np.max(np.abs(q - angles), initial=0.0))
    way = float(np.linalg.norm(at - body.cog))
    return Beginning(at, wanted, angles, way, abs(float(np.arctan2(np.sin(turn), np.cos(turn)))), joints)
