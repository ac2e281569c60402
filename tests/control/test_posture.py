"""From reach to angles, and the heading of the whole robot."""

from typing import Any

import numpy as np
import pytest

from skylimb.control.missions.reference import zero_reference
from skylimb.control.planning.posture import posture_family
from skylimb.control.planning.vectoring import vectoring_table
from skylimb.control.posture import heading_of, posture_of
from skylimb.robots.model import Robot

Q = np.array([1.1, 1.0, -0.5])
PSI = np.array([3.0, 0.1, 3.1, 0.2])
REFERENCE = zero_reference(3, 4)._replace(joint_angles=Q, vectoring_angles=PSI, reach=1.05, heading=0.4)


def flat(value: Any) -> np.ndarray:
    return np.asarray(value, dtype=float).ravel()


def test_at_the_references_reach_the_posture_is_the_references(robot: Robot) -> None:
    found = posture_of(posture_family(robot), vectoring_table(robot), 1.05, REFERENCE)
    np.testing.assert_allclose(flat(found.joint_angles), Q, atol=1e-12)
    np.testing.assert_allclose(flat(found.vectoring_angles), PSI, atol=1e-12)


@pytest.mark.parametrize("reach", [1.0, 1.1])
def test_another_reach_moves_the_posture_along_the_family(robot: Robot, reach: float) -> None:
    family, table = posture_family(robot), vectoring_table(robot)
    found = posture_of(family, table, reach, REFERENCE)
    theta, nominal = float(family.shape_angle(reach)), float(family.shape_angle(1.05))
    assert float(found.shape_angle) == pytest.approx(theta)
    moved = flat(family.joint_angles(theta)) - flat(family.joint_angles(nominal))
    np.testing.assert_allclose(flat(found.joint_angles) - Q, moved, atol=1e-12)
    turned = flat(table.angles(theta)) - flat(table.angles(nominal))
    np.testing.assert_allclose(flat(found.vectoring_angles) - PSI, turned, atol=1e-12)
    assert np.abs(moved).max() > 0.01
    assert np.abs(turned).max() > 0.001


@pytest.mark.parametrize("align", [0.0, 0.25, 1.0])
def test_the_robot_turns_so_that_the_tip_link_keeps_its_heading(robot: Robot, align: float) -> None:
    nominal = float(robot.at(Q, PSI).tip_heading)
    found = float(heading_of(robot, nominal + 0.2, REFERENCE._replace(align=align)))
    # With align = 1 the robot's own heading, that of {C} and of the tool in {C}, is the reference's.
    assert found + nominal + align * 0.2 == pytest.approx(0.4)
