"""From the wanted reach to joint and vectoring angles, and the heading that goes with them."""

from __future__ import annotations

from typing import Any, NamedTuple

from skylimb.control.missions.reference import Reference
from skylimb.control.planning.posture import ReachFamily
from skylimb.control.planning.vectoring import VectoringTable
from skylimb.robots.model import Robot
from skylimb.symbolic import Array


class Posture(NamedTuple):
    """Joint angles q, nominal vectoring angles psi and shape angle theta, rad."""

    joint_angles: Array
    vectoring_angles: Array
    shape_angle: Any


def posture_of(family: ReachFamily, table: VectoringTable, reach: Any, reference: Reference) -> Posture:
    """The nominal posture of the reference, moved along the family to another reach (m)."""
    theta, nominal = family.shape_angle(reach), family.shape_angle(reference.reach)
    joint_angles = reference.joint_angles + family.joint_angles(theta) - family.joint_angles(nominal)
    moved = table.angles(theta) - table.angles(nominal)
    return Posture(joint_angles, reference.vectoring_angles + moved, theta)


def heading_of(robot: Robot, tip_heading: Any, reference: Reference) -> Any:
    """The heading of {C}, rad, that puts the robot's heading on its own, as the joints turn.

    Args:
        robot: the controller's model.
        tip_heading: the heading (of tool or root) in {C} at the measured angles, rad.
        reference: of this tick.
    """
    nominal = robot.at(reference.joint_angles, reference.vectoring_angles).tip_heading
    return reference.heading - nominal - reference.align * (tip_heading - nominal)
