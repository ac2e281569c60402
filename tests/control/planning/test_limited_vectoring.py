"""Vectoring joints with limits, and robots without vectoring or bending joints, in the planning room."""

import numpy as np
import pytest

from made_robots import chain, multirotor
from skylimb.base.errors import UnreachableError
from skylimb.control.planning.posture import posture_family
from skylimb.control.planning.vectoring import vectoring_file, vectoring_table
from skylimb.control.planning.vectoring_digest import robot_digest
from skylimb.control.planning.vectoring_path import vectoring_path
from skylimb.robots import load_robot
from skylimb.robots.hover import find_hover

LIMIT = 0.3


@pytest.fixture(scope="module")
def turning(tmp_path_factory):
    """Four rotors, each turned about its arm by at most LIMIT; the most torque would need more."""
    return load_robot(multirotor(tmp_path_factory.mktemp("turning"), rotors=4, turn_limit=LIMIT))


def test_the_search_keeps_the_joint_limits(turning):
    angles = vectoring_table(turning, cache=False).angles(np.linspace(0.0, 1.0, 40))
    assert np.max(np.abs(angles)) <= LIMIT + 1e-6
    assert np.max(np.abs(angles)) > 0.9 * LIMIT  # and goes as far as it may


def test_the_digest_knows_the_limits_only_where_there_are_any(turning, tmp_path):
    wider = load_robot(multirotor(tmp_path, rotors=4, turn_limit=2 * LIMIT))
    assert robot_digest(wider) != robot_digest(turning)


def test_a_path_keeps_the_joint_limits(tmp_path):
    path = chain(tmp_path, bends=("0 0 1",), turns=("1 0 0",), turn_limit=0.25)
    robot = load_robot(path)
    postures = np.linspace(1.0, 1.15, 4)[:, None] * np.ones(3)
    hover = find_hover(robot, postures[0])
    assert hover
    start = hover.vectoring_angles
    found = vectoring_path(robot, postures, start)
    assert np.max(np.abs(found)) <= 0.25 + 1e-6
    free = load_robot(chain(tmp_path / "free", bends=("0 0 1",), turns=("1 0 0",), turn_limit=None))
    assert np.max(np.abs(vectoring_path(free, postures, start))) > 0.26


def test_without_vectoring_there_is_nothing_to_search(tmp_path):
    robot = load_robot(chain(tmp_path, turns=(), tilt=0.3, theta=(1.2, 1.6, 1.5)))
    table = vectoring_table(robot)
    assert table.angles(1.3).shape == (0,)
    assert table.angles(np.array([1.3, 1.4])).shape == (2, 0)
    assert vectoring_path(robot, np.ones((3, 3)), np.zeros(0)).shape == (3, 0)
    written = vectoring_file(robot)
    assert written is not None
    assert "coefficients = []" in written[1]


def test_a_rigid_robot_has_one_reach(tmp_path):
    robot = load_robot(multirotor(tmp_path))
    family = posture_family(robot)
    tip = robot.at([], []).tip_root - robot.at([], []).cog_root
    assert family.reach_min == family.reach_max == family.reach_nominal == pytest.approx(tip[0])
    assert family.shape_angle(family.reach_nominal) == family.theta_nominal
    assert family.joint_angles(family.theta_nominal).shape == (0,)
    assert family.slope(0.5) == 0.0
    with pytest.raises(UnreachableError):
        family.shape_angle(family.reach_nominal + 0.01)
