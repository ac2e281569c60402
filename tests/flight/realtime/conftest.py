"""The lab's robot, and measurements that it may send."""

from collections.abc import Callable

import numpy as np
import pytest

import skylimb
from skylimb.control.estimation.records import Measurement
from skylimb.control.planning.posture import posture_family
from skylimb.control.planning.vectoring import vectoring_table
from skylimb.robots.model import Robot


@pytest.fixture(scope="session")
def robot() -> Robot:
    return skylimb.load_robot("hydrus_xi_quad")


@pytest.fixture(scope="session")
def hovering(robot: Robot) -> Callable[..., Measurement]:
    """A measurement of the robot at rest, with some entries changed."""
    family = posture_family(robot)
    theta = family.theta_nominal
    angles = family.joint_angles(theta), vectoring_table(robot, "torque").angles(theta)
    q, psi = (np.asarray(part, dtype=float) for part in angles)
    z3 = np.zeros(3)

    def make(**changes: object) -> Measurement:
        usual = Measurement(np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0, 0.0]), z3, z3, q, psi)
        return usual._replace(**changes)

    return make
