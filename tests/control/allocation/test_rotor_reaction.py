"""The reaction that the allocation knows, against rotors as the plant has them."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.base.packing import numeric
from skylimb.base.rotations import rotation_from_rpy
from skylimb.control.allocation.laws import vectored
from skylimb.control.allocation.laws.bounded import whole_wrench
from skylimb.control.allocation.rotor_lag import RotorLag, Rotors
from skylimb.control.allocation.rotor_reaction import Reaction, motor_limits, reaction, reaction_torque
from skylimb.control.allocation.thrusts import unlimited
from skylimb.control.records import Demand, LawInput
from skylimb.robots.model import Robot
from skylimb.robots.posed import RobotState
from skylimb.simulation.rotors import rotor_numbers, rotor_tick

DT, LAG = 0.005, 0.05
NOW = np.array([9.0, 10.0, 11.0, 12.0])
TORQUE = np.array([0.1, -0.2, 0.15])


@pytest.fixture
def at(
    make_inputs: Callable[..., LawInput],
    robot: Robot,
    model: RobotState,
    joint_angles: Any,
    vectoring_angles: Any,
) -> LawInput:
    return make_inputs(model, robot=robot, q=joint_angles, psi=vectoring_angles)


def test_the_matrix_is_the_slope_of_the_torque(at: LawInput, robot: Robot) -> None:
    body, change = at.estimate.body, np.array([1e-4, -2e-4, 3e-4, 1e-4])
    known = reaction(robot, body, NOW, 40.0)
    found = reaction_torque(robot, body, NOW, NOW + change * 40.0 * DT, DT)
    np.testing.assert_allclose(known.matrix[3:] @ change, found, rtol=1e-4)
    assert not np.any(known.matrix[:3])


def test_thrusts_give_the_torque_with_their_reaction(at: LawInput, robot: Robot, model: RobotState) -> None:
    body, force = at.estimate.body, model.mass * model.gravity
    known = reaction(robot, body, NOW, 40.0)
    wanted = unlimited(body, force, TORQUE, hold_lift=True, reaction=known).total
    wrench = model.allocation_C @ wanted + known.matrix @ (wanted - NOW)
    np.testing.assert_allclose(wrench[3:], TORQUE, atol=1e-9)
    assert wrench[2] == pytest.approx((body.R_WC.T @ force)[2])
    assert np.abs(wanted - unlimited(body, force, TORQUE, hold_lift=True).total).max() > 0.05


def test_thrusts_give_the_whole_wrench_with_their_reaction(at: LawInput) -> None:
    """Six rows of six rotors: Q T_w + r G (T_w - T) is the wanted wrench."""
    robot = skylimb.load_robot("tilted_hexarotor")
    none = np.zeros(0)
    body = at.estimate.body._replace(model=robot.at(none, none), R_WC=rotation_from_rpy(0.1, -0.2, 0.4))
    force, now = robot.weight * np.array([0.1, -0.05, 1.0]), np.linspace(4.0, 6.0, 6)
    # The robot's file says no inertia: any matrix with torque rows stands for it.
    known = Reaction(np.vstack([np.zeros((3, 6)), 0.02 * np.arange(18.0).reshape(3, 6)]), now)
    wanted = whole_wrench(body, force, TORQUE, known).total
    wrench = body.model.allocation_C @ wanted + known.matrix @ (wanted - now)
    np.testing.assert_allclose(wrench, [*(body.R_WC.T @ force), *TORQUE], atol=1e-9)


def test_commands_at_the_limit_take_the_motors_torque(robot: Robot) -> None:
    """Of the plant's own rotors, up to the drag that grows within the tick."""
    least, most = motor_limits(robot, NOW, LAG)
    numbers = rotor_numbers(robot.description, DT)
    for command, sign in ((least, -1.0), (most, 1.0)):
        torques = np.array(rotor_tick(numbers, NOW, np.array(command), DT).motor_torques).ravel()
        free = (command > 1.0) & (command < 30.0)
        assert np.any(free)
        np.testing.assert_allclose(torques[free] * sign, 0.8, rtol=0.06)


def test_the_law_knows_the_reaction_of_its_own_command(
    at: LawInput, robot: Robot, model: RobotState, joint_angles: Any, vectoring_angles: Any
) -> None:
    gains = numeric(vectored.Gains(rotor_lag=RotorLag(compensate=True, reaction=True)))
    force = model.mass * model.gravity
    demand = Demand(force, force, TORQUE, joint_angles, vectoring_angles)
    before = vectored.State(np.zeros(3), Rotors(NOW, NOW), np.zeros(4))
    state, given, _ = vectored.step(gains, before, at, demand)
    mean = 0.5 * (NOW + np.asarray(state.rotors.thrusts).ravel())
    turned = reaction_torque(robot, at.estimate.body, NOW, np.asarray(state.rotors.thrusts).ravel(), DT)
    found = np.asarray(given.wrench.torque).ravel() - model.allocation_C[3:] @ mean
    np.testing.assert_allclose(found, turned, atol=0.02)
    assert np.linalg.norm(turned) > 0.05
