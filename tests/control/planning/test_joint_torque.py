"""What the servos of the joints hold in hover, against the physics engine; and ways that ask too much."""

import numpy as np
import pytest

import skylimb
from skylimb.control.planning.joint_torque import joint_torque_function, rest_function
from skylimb.control.planning.vectoring_merit import SPARED, merit_function, uphill_function
from skylimb.control.planning.vectoring_step import first_vectoring, settled_vectoring
from skylimb.flight.takeoff import take_off
from skylimb.robots.equilibrium import can_hold
from skylimb.robots.equilibrium_results import NotHeld, Within

BENT = np.array([0.11, 0.34, 0.14, -0.46, 0.40])
AGAINST = np.array([-2.39, -1.59, -4.71, 0.49, 1.36, -1.49])
"""hydrus_xi_hex nearly in a line; its rotors push against each other across it."""


def held_shares(robot, joint_angles, vectoring_angles):
    """Which share of its torque each servo of the shape joints gives in hover; above 1 it lets go."""
    torque = joint_torque_function(robot)(joint_angles, vectoring_angles).full().ravel()
    return np.abs(torque) / robot.description.shape_servos.torque_limit


@pytest.mark.parametrize("name", ["hydrus_xi_quad", "dragon"])
def test_they_are_what_the_engines_servos_give_after_take_off(name):
    (takeoff,) = take_off("free_flight", ("hybrid",), set={"robot": name, "posture.waypoints": []})
    robot, plant, data = takeoff.robot, takeoff.plant, takeoff.start
    q, psi = data.qpos[list(plant.joint_qpos)], data.qpos[list(plant.vectoring_qpos)]
    set_points = data.act[robot.n_rotors :][: robot.n_joints]
    torque = robot.description.shape_servos.stiffness * (set_points - q)
    assert np.abs(torque).max() > 0.2
    assert joint_torque_function(robot)(q, psi).full().ravel() == pytest.approx(-torque, abs=5e-3)
    assert np.abs(set_points - q).max() > 1e-3
    assert rest_function(robot)(set_points, psi).full().ravel() == pytest.approx(q, abs=5e-4)


def test_rotors_that_push_against_each_other_are_more_than_a_servo_holds():
    robot = skylimb.load_robot("hydrus_xi_hex")
    shares = held_shares(robot, BENT, AGAINST)
    assert np.argmax(shares) == 2
    assert shares[2] > 1.2
    best = first_vectoring(robot)
    assert held_shares(robot, robot.nominal_posture(), best.angles).max() < 0.8
    assert can_hold(robot, robot.nominal_posture(), best.angles)
    # Six rotors leave a choice of thrusts, and a robot may lean: level, none of them spares the servo enough.
    assert can_hold(robot, BENT, AGAINST)
    found = can_hold(robot, BENT, AGAINST, None, Within(0.1))
    assert isinstance(found, NotHeld)
    assert str(found) == "the servo of 'joint3' (3.3 N m) is in the way"


def test_the_gradient_of_the_merit_knows_what_servos_give():
    robot, small = skylimb.load_robot("hydrus_xi_hex"), 1e-6
    assert held_shares(robot, BENT, AGAINST).max() > SPARED
    _, gradient, _ = (np.array(part) for part in uphill_function(robot)(BENT, AGAINST))
    for slope, move in zip(gradient.ravel(), small * np.eye(6), strict=True):
        ends = [float(merit_function(robot)(BENT, AGAINST + sign * move)[0]) for sign in (1.0, -1.0)]
        assert slope == pytest.approx((ends[0] - ends[1]) / (2.0 * small), rel=1e-4, abs=1e-6)


def test_a_plan_spares_a_servo_and_gives_hardly_any_margin_for_it():
    robot = skylimb.load_robot("hydrus_xi_hex")
    plan = settled_vectoring(robot, BENT, AGAINST)
    assert held_shares(robot, BENT, plan.angles).max() < SPARED + 0.02
    assert plan.margin > 0.9 * float(merit_function(robot)(BENT, AGAINST)[1])
