"""The robots that ship: the numbers that their sources publish, and what their rotors can do."""

import numpy as np
import pytest

from skylimb.apps.robot_import.mechanics import actuation
from skylimb.control.planning.vectoring import vectoring_file, vectoring_table
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
    assert found.hover
    assert found.hover.room > 0.1
    assert found.hover.margin is not None
    assert found.hover.margin > 0.1


@pytest.mark.parametrize(
    ("name", "purpose"),
    [
        ("hydrus_xi_quad", "torque"), ("hydrus_xi_quad", "contact"), ("hydrus_xi_quad_mast", "contact"),
        ("hydrus_xi_hex", "torque"), ("hydrus_xi_hex", "contact"),
        ("dragon", "torque"), ("dragon", "contact"), ("tiltable_hexarotor", "torque"),
    ],
)  # fmt: skip
def test_the_vectoring_angles_that_ship_are_for_it_and_within_limits(name: str, purpose: str) -> None:
    robot = load_robot(name)
    table, file = vectoring_table(robot, purpose), vectoring_file(robot, purpose)
    assert file is not None
    assert table.digest in (robot.description.folder / file[0]).read_text()
    angles = table.angles(np.linspace(table.theta_min, table.theta_max, 50))
    lower, upper = robot.vectoring_limits()
    assert np.all(angles >= lower - 1e-3)
    assert np.all(angles <= upper + 1e-3)
