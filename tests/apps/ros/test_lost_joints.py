"""Joint states, or the IMU, are lost, and all else is well: the robot is seen, and flies back and down."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from skylimb.analysis.exchange import lab_topics as topics
from skylimb.analysis.exchange.messages import Vector
from skylimb.apps.ros.messages import Outgoing
from skylimb.apps.ros.states import FlightState
from wired import Wire, in_hover


def leads_back(fault: str) -> Wire:
    """One that hovers, and is led back since nothing is known of its joints."""
    wire = in_hover()
    begun = wire.pacer.time()

    def spoil(one: Outgoing) -> Outgoing | None:
        if one.topic is not topics.JOINT_STATES:
            return one
        names, angles = one.value.names, one.value.angles
        if fault == "missing":
            return Outgoing(one.topic, replace(one.value, names=names[1:], angles=angles[1:]))
        spoilt = Outgoing(one.topic, replace(one.value, angles=(math.nan, *angles[1:])))
        return None if fault == "lost" else spoilt

    wire.spoil = spoil
    wire.until(FlightState.LAND, 2.0)
    assert wire.pacer.time() - begun == pytest.approx(0.6, abs=0.05)
    flight = wire.pilot.pilot.flight
    assert flight is not None
    assert flight._guard.mode == "RETREAT"
    assert wire.pilot.faults["no joint angles for long"] > 0
    return wire


@pytest.mark.parametrize("fault", ["nan", "missing"])
def test_joints_of_which_nothing_is_felt_are_lost(fault: str) -> None:
    leads_back(fault)


def test_a_robot_that_feels_no_joints_flies_back_where_it_is_seen() -> None:
    wire = leads_back("lost")
    wire.until(FlightState.STOP, 15.0)
    assert wire.where[-1][2] == pytest.approx(0.15, abs=1e-3)  # it stands
    assert wire.sinks() < 0.5
    assert not wire.pilot.faults["pose too old"]
    wire.until(FlightState.ARM_OFF, 1.0)
    # By what is believed it does not start again.
    wire.tick("teleop_command/start")
    assert any(words.startswith("start is refused: age of joint angles: ") for words in wire.said)


def feels_no_rates(gyro: Vector | None) -> Wire:
    """One that hovers, and is led back since nothing is known of its rates."""

    def spoil(one: Outgoing) -> Outgoing | None:
        if one.topic is not topics.IMU:
            return one
        return None if gyro is None else one._replace(value=replace(one.value, gyro=gyro))

    wire = in_hover()
    begun = wire.pacer.time()
    wire.spoil = spoil
    wire.until(FlightState.LAND, 2.0)
    assert wire.pacer.time() - begun == pytest.approx(0.5, abs=0.05)
    flight = wire.pilot.pilot.flight
    assert flight is not None
    assert flight._guard.mode == "RETREAT"
    return wire


@pytest.mark.parametrize("gyro", [(math.nan, 0.0, 0.0), (0.0, 0.0, math.inf)])
def test_rates_that_are_no_numbers_are_none(gyro: Vector) -> None:
    feels_no_rates(gyro)


def test_a_robot_whose_imu_is_gone_flies_back_where_it_is_seen() -> None:
    """Its rates are differences of the attitudes that are seen."""
    wire = feels_no_rates(None)
    tilts = list[float]()
    for _ in range(3000):
        if wire.pilot.pilot.flying.state == FlightState.STOP:
            break
        wire.tick()
        _, x, y, _ = wire.robot.plant.truth().quaternion
        tilts.append(2.0 * math.hypot(x, y))
    assert wire.pilot.pilot.flying.state == FlightState.STOP
    assert wire.where[-1][2] == pytest.approx(0.15, abs=1e-3)  # it stands
    assert wire.sinks() < 0.5
    assert max(tilts) < 0.1
    assert not wire.pilot.faults["pose too old"]
    wire.until(FlightState.ARM_OFF, 1.0)
    wire.tick("teleop_command/start")
    assert any(words.startswith("start is refused: age of imu: ") for words in wire.said)
