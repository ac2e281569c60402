"""On the ground a robot whose sensors cannot be right, or say nothing, is not started."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from short_flights import CIRCLE
from skylimb.analysis.exchange import lab_topics as topics
from skylimb.analysis.exchange.messages import Imu
from skylimb.apps.ros.messages import Outgoing
from skylimb.apps.ros.states import FlightState
from wired import Wire, in_hover

BY_IMU = {
    **CIRCLE,
    "controller.estimation.smoothing.on": True,
    "controller.estimation.smoothing.imu": True,
    "sensors.imu.on": True,
}


def spoilt(imu: Imu, force: float, turning: float) -> Imu:
    """With its parts times these."""
    parts = force * np.array(imu.acceleration), turning * np.array(imu.gyro)
    acceleration, gyro = (tuple(map(float, part)) for part in parts)
    return replace(imu, acceleration=acceleration, gyro=gyro)


@pytest.mark.parametrize(
    ("force", "turning", "words"),
    [
        (-1.0, 1.0, "start is refused: IMU's force: 19."),
        (1.0 / 9.81, 1.0, "start is refused: IMU's force: 8.8 m/s^2 beside gravity"),
        (1.0, 57.3, "start is refused: IMU's turning: "),
        (1.0, 1.0, ""),
    ],
)
def test_an_imu_with_a_wrong_sign_or_unit_refuses_the_start(force: float, turning: float, words: str) -> None:
    wire = Wire(flown=("paper", "following", BY_IMU))

    def spoil(one: Outgoing) -> Outgoing:
        value: Any = one.value
        return Outgoing(one.topic, spoilt(value, force, turning)) if one.topic is topics.IMU else one

    wire.spoil = spoil
    started(wire)
    assert (wire.pilot.pilot.flying.state == FlightState.START) == (not words)
    assert not words or any(said.startswith(words) for said in wire.said)


@pytest.mark.parametrize("every", [2, 8])
def test_a_capture_that_is_too_slow_refuses_the_start(every: int) -> None:
    """With every eighth frame of 100 Hz it took off, swung up and fell."""
    wire, frames = Wire(), [0]

    def spoil(one: Outgoing) -> Outgoing | None:
        frames[0] += one.topic is topics.MOCAP
        return None if one.topic is topics.MOCAP and frames[0] % every else one

    wire.spoil = spoil
    wire.fly(0.5)
    started(wire)
    refused = "start is refused: rate of mocap/pose: 12.5 Hz (at least 18)" in wire.said
    assert refused == (every == 8)
    assert (wire.pilot.pilot.flying.state == FlightState.START) == (every == 2)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (None, "nothing valid on mocap/pose"),
        ({"stamp": 0.0}, "the newest pose is "),
    ],
)
def test_who_is_not_started_hears_why_its_position_is_not_known(
    change: dict[str, Any] | None, why: str
) -> None:
    """No capture, or one without stamps: each was "position: not known"."""
    wire = Wire()

    def spoil(one: Outgoing) -> Outgoing | None:
        value: Any = one.value
        if one.topic is not topics.MOCAP:
            return one
        return None if change is None else Outgoing(one.topic, replace(value, **change))

    wire.spoil = spoil
    started(wire)
    assert wire.pilot.pilot.flying.state == FlightState.ARM_OFF
    assert wire.said[0].startswith(f"start is refused: position: not known: {why}")


def test_a_battery_of_which_nobody_says_anything_refuses_the_start() -> None:
    wire = Wire()
    wire.spoil = lambda one: None if one.topic is topics.BATTERY else one
    started(wire)
    assert wire.pilot.pilot.flying.state == FlightState.ARM_OFF
    assert wire.said == ["start is refused: battery: not known (at least 10 %)"]


def tells(*volts: float) -> Callable[[Outgoing], Outgoing]:
    """What makes voltages of the battery's, one after the other and from the first on again."""
    said = itertools.cycle(volts)
    return lambda one: one._replace(value=next(said)) if one.topic is topics.BATTERY else one


@pytest.mark.parametrize("volts", [0.0, math.nan])
def test_a_voltage_that_is_none_any_more_refuses_the_start(volts: float) -> None:
    """The last good one stood for it, however long ago that was."""
    wire = Wire()
    wire.fly(0.2)
    wire.spoil = tells(volts)
    wire.fly(0.2)
    started(wire)
    assert wire.pilot.pilot.flying.state == FlightState.ARM_OFF
    assert wire.said == ["start is refused: battery: not known (at least 10 %)"]


def test_voltages_that_are_none_land_nobody() -> None:
    flying = in_hover()
    flying.spoil = tells(0.0, math.nan)
    flying.fly(4.0)
    assert flying.pilot.pilot.flying.state == FlightState.HOVER
    assert flying.pilot.faults["battery voltage is none of 6 cells"] >= 39


def test_where_nobody_tells_the_voltage_no_cells_say_so() -> None:
    wire = Wire(cells=0)
    wire.spoil = lambda one: None if one.topic is topics.BATTERY else one
    started(wire)
    assert wire.pilot.pilot.flying.state == FlightState.START


def started(wire: Wire) -> None:
    """After it has stood for a while."""
    wire.fly(0.3)
    wire.tick("teleop_command/start")
