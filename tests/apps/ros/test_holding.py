"""The flight controller holds the attitude by gains that add nothing to a robot that is commanded."""

from __future__ import annotations

import numpy as np
import pytest

from skylimb.analysis.exchange import lab_topics as topics
from skylimb.analysis.exchange.messages import Desire, FourAxes, Imu
from skylimb.apps.ros.attitude_loop import attitude_loop
from skylimb.apps.ros.grounded import STAND
from skylimb.apps.ros.holding import DAMPING, STIFFNESS, added, gains_of, no_gains
from skylimb.apps.ros.messages import Arrived
from skylimb.apps.ros.spinal import Spinal
from skylimb.apps.ros.states import FlightState
from skylimb.base.rotations import quaternion_from_rotation, rot_z, rotation_from_rpy
from steered import ready
from wired import Wire, in_hover

YAW = 0.7


@pytest.fixture
def hovering() -> Wire:
    return in_hover()


def tilt(wire: Wire) -> float:
    _, x, y, _ = wire.robot.plant.truth().quaternion
    return 2.0 * float(np.arcsin(min(1.0, np.hypot(x, y))))


def test_what_is_taken_off_is_what_the_flight_controller_adds() -> None:
    takeoff, _ = ready("hybrid")
    robot, first = takeoff.robot, takeoff.mission.first
    gains = gains_of(robot.at(first.joint_angles, first.vectoring_angles), YAW)
    axes, rates = Desire(0.1, -0.2, 0.4), np.array([0.3, -0.5, 0.2])
    R = np.asarray(rotation_from_rpy(0.15, -0.1, 2.0))
    w, x, y, z = quaternion_from_rotation(R).tolist()
    board = Spinal(4).received(gains, 0.0).received(axes, 0.0)._replace(armed=True)
    board = board.received(FourAxes((0.0, 0.0, 0.0), (10.0,) * 4), 0.0)
    _, thrusts = attitude_loop(board, R, rates, 0.0, 0.001, (np.full(4, -99.0), np.full(4, 99.0)))
    found = added(gains, axes, Imu(0.0, (0.3, -0.5, 0.2), quaternion_xyzw=(x, y, z, w)))
    assert np.abs(found).max() > 0.3
    np.testing.assert_allclose(thrusts - 10.0, found, atol=1e-9)


def test_they_turn_the_robot_as_they_should_and_lift_it_by_nothing() -> None:
    takeoff, _ = ready("hybrid")
    first = takeoff.mission.first
    state = takeoff.robot.at(first.joint_angles, first.vectoring_angles)
    gains, turn = 1e-3 * np.array(gains_of(state, YAW).motors), np.asarray(rot_z(-YAW))
    inertia = turn @ state.inertia_C @ turn.T
    for axis, columns in enumerate(((0, 2), (3, 5))):
        for column, share in zip(columns, (STIFFNESS**2, 2.0 * DAMPING * STIFFNESS), strict=True):
            wrench = state.allocation_C @ gains[:, column]
            np.testing.assert_allclose(turn[:2, :2] @ wrench[3:5], share * inertia[:2, axis], atol=5e-3)
            assert abs(wrench[2]) < 5e-3
    assert not gains[:, [1, 4, 6]].any()


def test_two_rotors_hold_nothing() -> None:
    takeoff, _ = ready("hybrid")
    first = takeoff.mission.first
    state = takeoff.robot.at(first.joint_angles, first.vectoring_angles)
    assert gains_of(state._replace(allocation_C=state.allocation_C[:, :2]), 0.0) == no_gains(2)


@pytest.mark.parametrize("touches", [False, True])
def test_a_robot_whose_node_is_killed_comes_down_level(hovering: Wire, touches: bool) -> None:
    """It met the ground with 0.4 to 1.8 rad of tilt."""
    if touches:
        hovering.ask(Arrived("skylimb/mission", "paper", "/client", 0.0))
        hovering.fly(9.0)
    leans = list[float]()
    for _ in range(800):
        hovering.fly_alone(0.005)
        leans.append(tilt(hovering))
    assert hovering.where[-1][2] < STAND + 0.01
    assert max(leans) < 0.3


def test_a_computer_that_stands_still_for_a_second_lands_its_robot(hovering: Wire) -> None:
    """It leaned by 0.95 rad, and its rotors were cut in the air."""
    hovering.stand_still(1.0)
    leans = [tilt(hovering)]
    while hovering.pilot.pilot.flying.state != FlightState.ARM_OFF:
        hovering.tick()
        leans.append(tilt(hovering))
    assert max(leans) < 0.3
    assert "the supervisor has cut the rotors: the flight controller is disarmed" not in hovering.said
    assert hovering.where[-1][2] < STAND + 0.01


def test_a_halt_takes_the_gains_away_at_once(hovering: Wire) -> None:
    hovering.spoil_down = lambda one: None if one.topic is topics.CONFIG else one
    hovering.fly(0.5)
    gains = hovering.robot._spinal.gains
    assert gains is not None
    assert gains.any()
    hovering.tick("teleop_command/halt")
    hovering.tick()
    gains, thrusts = hovering.robot._spinal.gains, hovering.robot._spinal.thrusts
    assert gains is not None
    assert not gains.any()
    assert thrusts is not None
    assert not thrusts.any()


def test_a_board_whose_imu_is_not_heard_gets_no_gains(hovering: Wire) -> None:
    hovering.spoil = lambda one: None if one.topic is topics.IMU else one
    hovering.fly(0.1)
    gains = hovering.robot._spinal.gains
    assert gains is not None
    assert not gains.any()
