"""A landing stops its motors on the ground, whatever thrust the rotors give and whatever the robot weighs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from short_flights import CIRCLE
from skylimb.analysis.exchange import lab_topics as topics
from skylimb.apps.ros.grounded import STAND
from skylimb.apps.ros.states import FlightState
from wired import SOON, Wire, in_hover

HIGH = replace(SOON, takeoff_height=1.5)
LAND = "teleop_command/land"

NOISE = dict.fromkeys(("position", "velocity", "attitude"), 10.0) | {"angular_velocity": 200.0}
BY_IMU = {
    "controller.estimation.smoothing.on": True,
    "controller.estimation.smoothing.imu": True,
    **{f"controller.estimation.smoothing.{name}": value for name, value in NOISE.items()},
    "sensors.imu.on": True,
}
"""A controller that flies on by its IMU where it sees nothing."""


def stops_on_the_ground(wire: Wire, seconds: float) -> None:
    """Its motors turn until it stands, and then no longer."""
    for _ in range(round(seconds / 0.005)):
        wire.tick()
        if not wire.armed:
            break
        assert wire.pilot.pilot.flying.state == FlightState.LAND or wire.where[-1][2] < STAND + 0.01
    assert not wire.armed, wire.said
    assert wire.where[-1][2] < STAND + 0.01


@pytest.mark.parametrize("lift", [pytest.param(0.0, marks=pytest.mark.slow), 0.1])
def test_a_robot_that_is_lifted_a_little_lands_on_the_ground(lift: float) -> None:
    """A part that it lost, or wind from below: the controller takes less away than it is lifted by."""
    wire = in_hover(HIGH)
    plant = wire.robot.plant
    plant._data.xfrc_applied[plant._root, 2] = lift * 9.81 * np.sum(plant._model.body_mass)
    wire.fly(2.0)
    before = len(wire.where)
    wire.tick(LAND)
    stops_on_the_ground(wire, 12.0)
    wire.where = wire.where[before:]
    assert wire.sinks() < 0.9


def test_rotors_that_are_stronger_than_a_new_controller_believes_land_the_robot() -> None:
    wire = Wire(limits=replace(HIGH, settled_z=0.1), plant={"plant.thrust_scale": 1.12})
    wire.hover()
    wire.fly_alone(0.2)
    wire.restart()
    wire.fly(0.1)
    assert wire.pilot.pilot.flying.state == FlightState.LAND
    stops_on_the_ground(wire, 12.0)
    assert wire.sinks() < 0.9


def test_a_robot_that_flies_on_by_its_imu_is_not_stopped_in_the_air() -> None:
    """Steady flight feels as the ground does."""
    wire = Wire(flown=("paper", "following", {**CIRCLE, **BY_IMU}), limits=replace(SOON, takeoff_height=2.0))
    wire.hover()
    wire.spoil = lambda one: None if one.topic is topics.MOCAP else one
    wire.fly(0.7)
    flight = wire.pilot.pilot.flight
    assert flight is not None
    assert flight._guard.mode == "RETREAT"
    stops_on_the_ground(wire, 15.0)
    assert any(words.startswith("blind landing ends") for words in wire.said)


def test_whoever_lands_before_it_lifted_stops_soon() -> None:
    wire = Wire()
    wire.fly(0.15)
    wire.tick("teleop_command/start")
    wire.until(FlightState.ARM_ON, 1.0)
    wire.tick("teleop_command/takeoff")
    wire.fly(0.3)
    wire.tick(LAND)
    stops_on_the_ground(wire, 2.0)


@pytest.mark.parametrize("order", ["halt", "force_landing"])
def test_a_landing_that_takes_thrust_away_is_still_halted_and_forced(order: str) -> None:
    wire = in_hover()
    wire.tick(LAND)
    for _ in range(1200):
        wire.tick()
        if wire.pilot.pilot.flying.eases:
            break
    wire.tick(f"teleop_command/{order}")
    wire.fly(0.05)
    assert wire.armed == (order == "force_landing")
    wire.until(FlightState.ARM_OFF, 6.0)
    assert not wire.armed
