"""A controller that dies, a capture that is gone, a board that nobody here armed: the robot comes down."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from skylimb.analysis.exchange import lab_topics as topics
from skylimb.apps.ros.grounded import STAND
from skylimb.apps.ros.messages import Outgoing
from skylimb.apps.ros.states import FlightState
from skylimb.flight.realtime.guard import STALLED
from wired import SOON, Wire, in_hover

HALT, FORCE, LAND = (f"teleop_command/{word}" for word in ("halt", "force_landing", "land"))


@pytest.fixture
def hovering() -> Wire:
    return in_hover()


def killed(wire: Wire, seconds: float = 0.3) -> None:
    """The controller dies, and begins anew after some time in which nobody commands the robot."""
    wire.fly_alone(seconds)
    wire.restart()


def test_a_controller_that_begins_anew_in_hover_lands_the_robot(hovering: Wire) -> None:
    killed(hovering)
    hovering.fly(0.5)
    assert "the flight controller is armed, and nobody here armed it: landing" in hovering.said
    assert hovering.pilot.pilot.flying.state == FlightState.LAND
    hovering.until(FlightState.STOP, 10.0)
    hovering.until(FlightState.ARM_OFF, 1.0)
    assert hovering.sinks() < 0.8
    assert not hovering.armed
    assert hovering.where[-1][2] < STAND + 0.01


def test_a_controller_that_begins_anew_may_go_on_hovering() -> None:
    wire = Wire(limits=replace(SOON, adopt="hover"))
    wire.hover()
    before = wire.robot.plant.truth().position.copy()
    killed(wire, 0.1)
    wire.fly(4.0)
    assert "the flight controller is armed, and nobody here armed it: hovering" in wire.said
    assert wire.pilot.pilot.flying.state == FlightState.HOVER
    assert np.linalg.norm(wire.where[-1] - before) < 0.3
    assert abs(wire.where[-1] - wire.where[-100]).max() < 0.02  # it stands in the air
    wire.tick(LAND)
    wire.until(FlightState.ARM_OFF, 12.0)
    assert not wire.armed


@pytest.mark.usefixtures("rotors_come_up_slowly")
def test_a_controller_that_begins_anew_sees_what_thrust_the_rotors_need() -> None:
    wire = Wire(limits=replace(SOON, adopt="hover", takeoff_height=1.5), plant={"plant.thrust_scale": 0.85})
    wire.hover()
    before = wire.where[-1].copy()
    killed(wire, 0.2)
    wire.fly(4.0)
    flight = wire.pilot.pilot.flight
    assert flight is not None
    assert flight.lift.needs == pytest.approx(1.0 / 0.85, rel=0.02)
    assert wire.pilot.pilot.flying.state == FlightState.HOVER
    assert np.linalg.norm(wire.where[-1] - before) < 0.1
    assert np.array(wire.where)[-900:, 2].min() > before[2] - 0.45


def test_rotors_that_the_supervisor_cuts_are_disarmed(hovering: Wire) -> None:
    flight = hovering.pilot.pilot.flight
    assert flight is not None
    flight._guard.stop()
    hovering.until(FlightState.STOP, 0.1)
    hovering.until(FlightState.ARM_OFF, 0.2)
    assert not hovering.armed
    assert "the supervisor has cut the rotors: the flight controller is disarmed" in hovering.said


def test_a_robot_that_is_knocked_over_in_the_air_is_disarmed(hovering: Wire) -> None:
    hovering.robot.plant._data.qvel[3] = 9.0
    hovering.until(FlightState.STOP, 1.0)
    hovering.until(FlightState.ARM_OFF, 0.2)
    assert not hovering.armed
    assert "the supervisor has cut the rotors: the flight controller is disarmed" in hovering.said


def test_a_computer_that_stood_still_finds_the_robot_anew_and_lands_it(hovering: Wire) -> None:
    """Its thrusts stood still too; by what was predicted before no pose was believed, and it fell."""
    hovering.stand_still(0.52)
    leans = list[float]()
    hovering.tick()
    assert hovering.pilot.pilot.flying.state == FlightState.LAND
    while hovering.pilot.pilot.flying.state == FlightState.LAND:
        hovering.tick()
        _, x, y, _ = hovering.robot.plant.truth().quaternion
        leans.append(2.0 * float(np.arcsin(np.hypot(x, y))))
    hovering.until(FlightState.ARM_OFF, 1.0)
    assert not hovering.armed
    assert hovering.pilot.faults[STALLED] == 1
    assert hovering.pilot.faults["jump"] == 0
    assert max(leans) < 0.65
    assert leans[-1] < 0.25
    assert hovering.where[-1][2] < STAND + 0.01
    assert "the supervisor has cut the rotors: the flight controller is disarmed" not in hovering.said


def test_a_cut_stays_a_cut_when_the_computer_stands_still(hovering: Wire) -> None:
    flight = hovering.pilot.pilot.flight
    assert flight is not None
    flight._guard.stop()
    hovering.spoil_down = lambda one: None if one.topic is topics.CONFIG else one
    hovering.fly(0.05)
    assert flight.cut
    hovering.stand_still(0.6)
    hovering.fly(0.1)
    assert flight.cut
    assert hovering.pilot.pilot.flying.state == FlightState.STOP


@pytest.mark.parametrize("takes_off", [False, True])
def test_a_robot_that_stands_with_idle_motors_is_disarmed_and_its_rotors_do_not_come_up(
    takes_off: bool,
) -> None:
    """They came up to its weight, to land a robot that stood."""
    wire, most = Wire(), 0.0
    wire.fly(0.15)
    wire.tick("teleop_command/start")
    wire.until(FlightState.ARM_ON, 1.0)
    if takes_off:
        wire.tick("teleop_command/takeoff")
        wire.fly(0.1)
    killed(wire, 0.2)
    for _ in range(200):
        wire.tick()
        thrusts = wire.robot._spinal.thrusts
        most = max(most, 0.0 if thrusts is None else float(thrusts.sum()))
    assert wire.said[1:] == ["ARM_OFF -> STOP", "STOP -> ARM_OFF"]
    assert "its motors idle" in wire.said[0]
    assert not wire.armed
    assert most < 0.3 * wire.robot._robot.weight


def most_thrust(wire: Wire, seconds: float) -> float:
    """Fly on; the most that the rotors gave, in weights."""
    most = 0.0
    for _ in range(round(seconds / 0.005)):
        wire.tick()
        thrusts = wire.robot._spinal.thrusts
        most = max(most, 0.0 if thrusts is None else float(thrusts.sum()) / wire.robot._robot.weight)
    return most


def test_a_robot_that_its_board_has_landed_by_force_is_disarmed_where_it_stands(hovering: Wire) -> None:
    """The board leaves its rotors turning with 0.7 of its weight; they came up to 1.1 times it."""
    killed(hovering, 3.0)
    assert hovering.where[-1][2] == pytest.approx(STAND, abs=0.01)
    assert most_thrust(hovering, 1.0) < 0.7
    assert not hovering.armed
    assert "give too little to fly" in hovering.said[0]
    assert hovering.said[1:] == ["ARM_OFF -> STOP", "STOP -> ARM_OFF"]


@pytest.mark.parametrize("order", [HALT, FORCE])
def test_whoever_believes_that_nothing_flies_stops_it_all_the_same(hovering: Wire, order: str) -> None:
    killed(hovering, 0.05)
    hovering.tick(order)
    hovering.fly(0.1)
    assert (not hovering.armed) == (order == HALT)
    hovering.until(FlightState.ARM_OFF, 10.0)
    assert not hovering.armed


def test_a_capture_that_is_gone_for_good_ends_on_the_ground_with_its_motors_off(hovering: Wire) -> None:
    hovering.spoil = lambda one: None if one.topic is topics.MOCAP else one
    hovering.fly(0.7)
    assert hovering.pilot.pilot.flying.force_landing
    hovering.until(FlightState.ARM_OFF, 6.0)
    assert any(words.startswith("blind landing ends") for words in hovering.said)
    # Its last thrusts still carry a part of it, so it may slide; but it is down.
    assert hovering.robot.plant.truth().position[2] == pytest.approx(STAND, abs=0.01)
    assert not hovering.armed


def test_nothing_is_measured_any_more_and_it_ends_by_its_time(hovering: Wire) -> None:
    hovering.spoil = lambda one: one if one.topic in (topics.ACK, topics.PWMS) else None
    hovering.until(FlightState.ARM_OFF, 8.0)
    assert any("it must be down after" in words for words in hovering.said)
    assert not hovering.armed


def test_a_disarm_is_repeated_until_it_is_heard_and_a_board_that_others_arm_again_is_stopped(
    hovering: Wire,
) -> None:
    deaf = True

    def spoil(one: Outgoing) -> Outgoing | None:
        return None if deaf and one.topic is topics.CONFIG else one

    hovering.spoil_down = spoil
    hovering.tick(HALT)
    hovering.fly(1.0)
    assert hovering.armed
    assert hovering.pilot.pilot.flying.state == FlightState.STOP
    deaf = False
    hovering.until(FlightState.ARM_OFF, 0.2)
    assert not hovering.armed
    hovering.down.append(Outgoing(topics.CONFIG, 0))
    hovering.tick()
    assert hovering.armed
    hovering.fly(0.6)
    assert "the flight controller is armed still: it is stopped again" in hovering.said
    assert not hovering.armed


def test_a_board_that_does_not_hear_that_it_is_disarmed_hears_that_it_is_to_thrust_no_more(
    hovering: Wire,
) -> None:
    """It flew on with its last thrusts for 0.5 s, then by 7 N a rotor for ever."""
    hovering.spoil_down = lambda one: None if one.topic is topics.CONFIG else one
    hovering.tick(HALT)
    hovering.fly(1.0)
    assert hovering.pilot.pilot.flying.state == FlightState.STOP
    assert hovering.robot._spinal.thrusts is not None
    assert hovering.robot._spinal.thrusts.max() == 0.0
    assert hovering.where[-1][2] < STAND + 0.01
    hovering.spoil_down = lambda one: one
    hovering.until(FlightState.ARM_OFF, 0.2)
    assert not hovering.armed


def test_a_robot_that_lies_on_its_side_does_not_start() -> None:
    wire = Wire()
    plant = wire.robot.plant
    plant._data.qpos[3:7] = [np.cos(0.8), np.sin(0.8), 0.0, 0.0]
    plant._stands = plant._data.qpos[0:7].copy()
    wire.fly(0.2)
    wire.tick("teleop_command/start")
    assert wire.pilot.pilot.flying.state == FlightState.ARM_OFF
    assert wire.said == ["start is refused: position: not known: jump (a fresh pose, gyro and joint angles)"]
    wire.fly(4.0)  # it is believed that somebody has laid it down
    wire.tick("teleop_command/start")
    assert wire.said[-1] == "start is refused: attitude: 1.6 rad of tilt (at most 0.2)"
