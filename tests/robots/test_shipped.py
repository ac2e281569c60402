"""The robots that ship: the numbers that their sources publish, and what their rotors can do."""

import numpy as np
import pytest

from skylimb.descriptions.mechanics import actuation
from skylimb.planning.vectoring import vectoring_table
from skylimb.planning.vectoring_digest import robot_digest
from skylimb.robots import load_robot

# Mass (kg) as published, joints, vectoring joints, rotors, rank with vectoring at rest and with it moving.
PUBLISHED = {
    "hydrus_quad": (3.8309, 3, 0, 4, 4, 4),
    "hydrus_xi_hex": (5.9252, 5, 6, 6, 6, 6),
    "dragon": (6.9845, 6, 8, 4, 4, 6),
    "tilted_hexarotor": (3.58, 0, 0, 6, 6, 6),
    "tiltable_hexarotor": (1.922, 0, 6, 6, 6, 6),
}


@pytest.mark.parametrize("name", PUBLISHED)
def test_published_numbers(name):
    robot = load_robot(name)
    mass, joints, vectoring, rotors, rank, moving = PUBLISHED[name]
    assert robot.mass == pytest.approx(mass, abs=1e-4)
    assert (robot.n_joints, robot.n_vectoring, robot.n_rotors) == (joints, vectoring, rotors)
    found = actuation(robot)
    assert (found.rank, found.rank_moving) == (rank, moving)
    assert found.hover is not None
    assert found.hover.margin > 0.1


@pytest.mark.parametrize("name", [name for name, row in PUBLISHED.items() if row[2]])
def test_the_vectoring_angles_that_ship_are_for_it_and_within_limits(name):
    robot = load_robot(name)
    assert robot_digest(robot) in (robot.description.folder / "vectoring.toml").read_text()
    posture = robot.description.posture
    angles = vectoring_table(robot).angles(np.linspace(posture.theta_min, posture.theta_max, 50))
    lower, upper = robot.vectoring_limits()
    assert np.all(angles >= lower - 1e-3)
    assert np.all(angles <= upper + 1e-3)
