"""A radio lands, stops, steers, and is missed when it is silent."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from skylimb.analysis.exchange.lab_topics import JOY
from skylimb.analysis.exchange.messages import Joy, NavMode
from skylimb.apps.ros.limits import FlightLimits
from skylimb.apps.ros.messages import Arrived
from skylimb.apps.ros.pad import Pad
from skylimb.apps.ros.radio import ordered, steered
from skylimb.apps.ros.run import limits_of
from skylimb.apps.ros.sorting import MessageSorter
from skylimb.apps.ros.states import FORCE_LANDING, FlightState, Order
from skylimb.base.errors import ConfigError
from steered import Steered, in_hover

REST = Joy(0.0, (0.0,) * 6, (0,) * 8)
A, B, FORWARD = (
    replace(REST, buttons=(1, 0)),
    replace(REST, buttons=(0, 1)),
    replace(REST, axes=(0.0, 0.0, 0.0, 0.0, 1.0, 0.0)),
)


def test_a_button_orders_once_as_it_is_pressed() -> None:
    assert ordered(None, A, Pad()) == ordered(REST, A, Pad()) == [Order.LAND]
    assert (
        ordered(A, A, Pad())
        == ordered(A, REST, Pad())
        == ordered(None, replace(REST, buttons=()), Pad())
        == []
    )
    assert ordered(A, B, Pad()) == [Order.HALT]


def test_sticks_ask_for_a_velocity_in_the_robots_axes() -> None:
    limits = FlightLimits()
    assert steered(REST, limits) is None
    assert steered(replace(REST, axes=(0.19, -0.19, 1.0)), limits) is None
    nav = steered(replace(REST, axes=(-0.5, 0.5, 0.0, 1.0, -1.0)), limits)
    assert nav is not None
    assert {nav.xy_mode, nav.z_mode, nav.yaw_mode} == {NavMode.VELOCITY}
    assert nav.velocity == (-0.5, 0.5, 0.25)
    assert (nav.yaw_rate, nav.frame) == (-0.15, 1)
    assert steered(replace(REST, axes=(1.0,)), limits) is not None


@pytest.mark.parametrize("wrong", [float("nan"), float("inf")])
def test_an_axis_that_is_no_number_asks_for_nothing(wrong: float) -> None:
    joy, sorter = replace(REST, axes=(0.0, 0.0, 0.0, wrong, 0.0)), MessageSorter(6)
    received = sorter.sort([Arrived(JOY.name, joy, "/joy", 1.0)])
    assert (received.requests, received.taken_over) == ((), False)
    assert sorter.counts == {"axis of joy is no number": 1}
    nav = steered(replace(joy, axes=(0.0, 0.0, 0.0, wrong, 1.0)), FlightLimits())
    assert nav is not None
    assert nav.velocity == (0.5, 0.0, 0.0)


def test_what_a_radio_says_is_sorted_into_orders_and_steering() -> None:
    sorter = MessageSorter(6)
    received = sorter.sort([Arrived(JOY.name, FORWARD, "/joy", 1.0), Arrived(JOY.name, A, "/joy", 1.01)])
    assert (received.orders, received.radio, received.taken_over) == ((Order.LAND,), 1.01, False)
    assert len(received.requests) == 1
    assert sorter.sort([]).radio is None


@pytest.fixture
def hovering() -> Steered:
    return in_hover()


def radio(robot: Steered, joy: Joy, seconds: float) -> None:
    sorter = MessageSorter(6)
    for _ in range(round(seconds / 0.005)):
        robot.tick(received=sorter.sort([Arrived(JOY.name, joy, "/joy", robot.pacer.time())]))


def test_a_stick_that_is_moved_ends_the_mission_and_steers(hovering: Steered) -> None:
    hovering.tick(mission="paper")
    while not (script := hovering.tick().script) or not script.begun:
        pass
    before = hovering.ticks[-1].body
    radio(hovering, replace(REST, axes=(0.0, 0.0, 0.0, 0.0, -1.0)), 2.0)
    assert "mission 'paper': given up, the radio took over; hovering away from it" in hovering.said
    after = hovering.ticks[-1].body
    assert before is not None
    assert after is not None
    ahead = np.array([np.cos(before.yaw), np.sin(before.yaw)])
    assert (after.cog - before.cog)[:2] @ ahead < -0.3
    radio(hovering, REST, 0.5)
    assert hovering.state == FlightState.HOVER


def test_a_radio_that_is_silent_lands_the_robot(hovering: Steered) -> None:
    hovering.fly(1.5)
    assert hovering.state == FlightState.HOVER  # nobody had one
    radio(hovering, REST, 0.2)
    hovering.fly(0.9)
    assert hovering.state == FlightState.HOVER
    hovering.fly(0.3)
    assert (hovering.state, hovering.ticks[-1].flying.shown) == (FlightState.LAND, FORCE_LANDING)
    assert "force landing: the radio is silent" in hovering.said


def test_a_radio_that_is_silent_already_lets_nothing_begin() -> None:
    robot = Steered()
    robot.tick()
    radio(robot, REST, 0.1)
    robot.fly(1.2)
    robot.tick(Order.START)
    assert robot.said == ["start is refused: age of the radio: 1.21 s (at most 1)"]
    radio(robot, REST, 0.1)
    robot.tick(Order.START)
    robot.until(FlightState.ARM_ON)
    robot.fly(1.2)
    robot.tick(Order.TAKEOFF)
    assert any(words.startswith("takeoff stops: age of the radio") for words in robot.said)
    assert robot.state == FlightState.STOP


def test_another_pad_has_other_numbers() -> None:
    pad = limits_of(None, {"land": 7, "halt": 2, "forward": 0, "yaw": 4}, "land").pad
    pressed = replace(REST, buttons=(1, 0, 0, 0, 0, 0, 0, 1))
    assert ordered(REST, pressed, pad) == [Order.LAND]
    nav = steered(replace(REST, axes=(1.0, 0.0, 0.0, 0.0, 0.0)), FlightLimits(pad=pad))
    assert nav is not None
    assert nav.velocity == (0.5, 0.0, 0.0)
    for wrong, words in (
        ({"lnad": 1}, "land"),
        ({"land": 1}, "--pad.*halt"),
        ({"up": 4}, "--pad.*means two things"),
        ({"yaw": -1}, "yaw = -1"),
        ({"yaw": 1.5}, "yaw"),
    ):
        with pytest.raises(ConfigError, match=words):
            limits_of(None, wrong, "land")
