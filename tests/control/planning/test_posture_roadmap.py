"""Ways between postures, rehearsed on the ground: straight where that leaves enough, else through others."""

import itertools

import numpy as np
import pytest

from skylimb.control.planning.joint_torque import HELD
from skylimb.control.planning.posture_rehearsal import rehearse, straight_way
from skylimb.control.planning.posture_roadmap import Roadmap, keeps_clear
from skylimb.control.planning.vectoring_step import first_vectoring, plan_vectoring
from skylimb.robots import Robot, load_robot

GOOD = np.array([[1.3, 1.0, -0.2], [0.8, 1.2, 0.4], [1.0, 0.6, 1.0]])
ACROSS = np.array([[0.6, 0.4, 0.3], [-0.6, -0.4, -0.3]])
"""The straight way between them leads through the robot with all links in a line."""


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("hydrus_xi_quad")


def test_a_straight_way_ends_at_its_end_in_small_steps():
    way = straight_way(GOOD[0], GOOD[1])
    assert np.array_equal(way[-1], GOOD[1])
    assert np.abs(np.diff(np.vstack([GOOD[0], way]), axis=0)).max() <= 0.02
    assert straight_way(GOOD[0], GOOD[0]).shape == (1, 3)


def test_a_rehearsal_is_the_plans_one_after_another(robot):
    way, psi = straight_way(robot.nominal_posture(), GOOD[0]), first_vectoring(robot).angles
    rehearsal = rehearse(robot, way, psi)
    for q, angles, margin in zip(way, rehearsal.vectoring_angles, rehearsal.margins, strict=True):
        plan = plan_vectoring(robot, q, psi)
        psi = plan.angles
        assert np.array_equal(angles, psi)
        assert margin == plan.margin
    assert rehearsal.last.margin == rehearsal.margins[-1]
    assert rehearsal.first_without(rehearsal.margins.min() - 1e-9) is None
    assert rehearsal.first_without(30.0) == 0


def test_every_way_that_is_found_leaves_enough(robot):
    roadmap = Roadmap(robot, np.vstack([GOOD, ACROSS]), least=1.9)
    ways = [roadmap.way(roadmap.start, k) for k in range(1, 6)]
    assert sum(way is not None for way in ways) >= 3
    for way in filter(None, ways):
        for one, other in itertools.pairwise(way):
            line = straight_way(roadmap.postures[one.posture], roadmap.postures[other.posture])
            flown = rehearse(robot, line, roadmap.vectoring_angles(one))
            assert flown.margins.min() >= 1.9
            assert flown.servos.max() <= HELD
        assert way[0] == roadmap.start


def test_where_the_straight_way_leaves_too_little_it_goes_round_or_not_at_all(robot):
    roadmap = Roadmap(robot, np.vstack([GOOD, ACROSS]), least=1.9)
    begin = roadmap.way(roadmap.start, 4)
    assert begin is not None
    assert roadmap.edge(begin[-1], 5) is None
    way = roadmap.way(begin[-1], 5)
    assert way is None or len(way) > 2


def test_links_keep_their_distance(robot):
    ring = np.array([[1.57, 1.57, 1.57]])
    assert not keeps_clear(robot, ring, 0.15)  # the tip's link closes the square
    assert keeps_clear(robot, GOOD, 0.15)
    assert keeps_clear(robot, ring, 0.0)


def test_joints_in_one_place_are_one_joint():
    """DRAGON's pitch and yaw joints share their origins; neighbours are no collision."""
    dragon = load_robot("dragon")
    assert keeps_clear(dragon, dragon.nominal_posture()[None], 0.15)
