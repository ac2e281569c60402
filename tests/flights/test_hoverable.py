"""Postures that leave too little are refused before take-off, with the nearest that leaves enough."""

import re

import numpy as np
import pytest

import skylimb
from skylimb.errors import ConfigError
from skylimb.flights.hoverable import _refusal
from skylimb.flights.takeoff import take_off
from skylimb.missions.posture import posture_plan
from skylimb.planning.posture_limits import nearest_posture, weakest_margin
from skylimb.planning.posture_path import PostureConfig
from skylimb.planning.vectoring_step import first_vectoring, settled_vectoring

STRAIGHT = [[0.0, 0.0, 0.0]]


def refused(**given) -> str:
    with pytest.raises(ConfigError) as raised:
        take_off("free_flight", ("pid",), 0, given)
    return str(raised.value)


def test_a_way_through_a_weak_posture_is_refused_with_torque_place_and_nearest():
    said = refused(**{"posture.margin": 2.5, "posture.waypoints": STRAIGHT})
    assert re.search(r"(roll|pitch|yaw) torque margin of [0-2]\.\d+ N m at q = \[", said)
    assert re.search(r"\d\.\d s after posture\.waypoints begin, below 2\.5 N m \(posture\.margin\)", said)
    nearest = np.array(re.findall(r"-?\d\.\d+", said.rpartition("leaves it is")[2]), dtype=float)
    # It leaves enough, with angles of its own.
    robot = skylimb.load_robot("hydrus_xi_quad")
    found = [
        settled_vectoring(robot, nearest, psi).margin
        for psi in np.random.default_rng(0).uniform(-3, 3, (6, 4))
    ]
    assert max(found) > 2.4


def test_where_only_the_vectoring_angles_are_weak_it_says_so():
    robot = skylimb.load_robot("hydrus_xi_quad")
    q, weak = robot.nominal_posture(), first_vectoring(robot).angles + 0.4 * np.array([1.0, -1.0, 1.0, -1.0])
    said = _refusal(robot, posture_plan(PostureConfig(), robot), (0.0, q, weak), 3.0)
    assert "other vectoring angles leave it there, so come to it another way" in said
    assert "nearest posture" not in said


def test_a_margin_that_is_left_lets_it_fly():
    take_off("free_flight", ("pid",), 0, {"posture.margin": 1.0, "posture.waypoints": []})


def test_more_than_any_posture_leaves_says_so():
    assert "no posture near it leaves more" in refused(**{"posture.margin": 30.0, "posture.waypoints": []})


def test_a_thrust_near_its_limit_is_named():
    robot = skylimb.load_robot("hydrus_quad")
    weakest = weakest_margin(robot, robot.nominal_posture(), np.zeros(0))
    thrusts = robot.at(robot.nominal_posture(), []).hover_thrusts
    rooms = np.minimum(thrusts - 1.0, 18.0 - thrusts)
    rotor = int(np.argmin(rooms)) + 1
    assert weakest.name in (f"hover thrust of rotor {rotor}", "roll torque", "pitch torque", "yaw torque")
    # A posture in which a rotor has to push: the model says which.
    q = np.array([1.1, 0.3, 0.5])
    thrusts = robot.at(q, []).hover_thrusts
    rooms = np.minimum(thrusts - 1.0, 18.0 - thrusts)
    if rooms.min() < 0.0:
        assert weakest_margin(robot, q, np.zeros(0)).name == f"hover thrust of rotor {np.argmin(rooms) + 1}"


def test_the_nearest_posture_of_a_good_one_is_itself():
    robot = skylimb.load_robot("hydrus_xi_quad")
    q = robot.nominal_posture()
    psi = settled_vectoring(robot, q, robot.description.vectoring_start).angles
    assert nearest_posture(robot, q, psi, 1.0) == pytest.approx(q, abs=1e-4)
