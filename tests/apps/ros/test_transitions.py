"""The lab's flight states, one transition after another, and what they refuse."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from skylimb.apps.ros.battery import percentage
from skylimb.apps.ros.limits import FlightLimits
from skylimb.apps.ros.states import (
    FORCE_LANDING,
    LOW_BATTERY,
    Arming,
    FlightState,
    Flying,
    Order,
    Seen,
)
from skylimb.apps.ros.transitions import advance
from skylimb.flight.realtime.landing import STANDS

LIMITS = FlightLimits()
HERE = np.array([1.0, 2.0, 0.2])
UP = np.array([1.0, 2.0, 0.6])


def seen(now: float = 0.0, *orders: Order, position: np.ndarray | None = HERE, **more: object) -> Seen:
    return replace(Seen(now, position, orders=orders), **more)


def at(state: FlightState, **more: object) -> Flying:
    return replace(Flying(state, origin=HERE), **more)


def after(flying: Flying, *steps: Seen) -> tuple[Flying, list[str]]:
    said: list[str] = []
    for step in steps:
        flying, words = advance(flying, step, LIMITS)
        said += words
    return flying, said


def test_a_whole_flight_goes_through_the_states() -> None:
    flying, said = after(Flying(), seen(0.0, Order.START))
    assert (flying.state, flying.arming) == (FlightState.START, Arming.ON)
    flying, _ = after(flying, seen(0.1), seen(0.2, acknowledged=0))
    assert (flying.state, flying.arming) == (FlightState.ARM_ON, None)
    flying, _ = after(flying, seen(1.0, Order.TAKEOFF))
    assert flying.state == FlightState.TAKEOFF
    flying, _ = after(flying, *(seen(1.0 + 0.1 * k, position=UP, target=UP) for k in range(1, 10)))
    assert flying.state == FlightState.TAKEOFF
    flying, _ = after(flying, seen(2.05, position=UP, target=UP))
    assert flying.state == FlightState.HOVER
    flying, _ = after(flying, seen(3.0, Order.LAND, position=UP))
    assert flying.state == FlightState.LAND
    below = HERE - [0.0, 0.0, 0.3]
    flying, _ = after(flying, *(seen(3.0 + 0.6 * k, target=below, light=True) for k in range(1, 4)))
    assert (flying.state, flying.arming) == (FlightState.STOP, Arming.OFF)
    flying, _ = after(flying, seen(4.3), seen(4.4, acknowledged=1))
    assert flying.state == FlightState.ARM_OFF
    assert said == []


@pytest.mark.parametrize("state", [one for one in FlightState if one != FlightState.ARM_OFF])
def test_start_in_any_other_state_is_refused_and_said(state: FlightState) -> None:
    flying, said = after(at(state, settled=0.0), seen(0.0, Order.START))
    assert flying.state == state
    why = {
        FlightState.START: "it has begun already",
        FlightState.ARM_ON: "the robot is armed already; takeoff comes next",
        FlightState.STOP: "the flight controller has not confirmed yet that the motors are off",
    }.get(state, "it would reset the controller of this flight")
    assert said == [f"start is refused in {state.name}: {why}"]


@pytest.mark.parametrize("state", [FlightState.HOVER, FlightState.LAND])
def test_takeoff_in_the_air_is_refused_and_said(state: FlightState) -> None:
    flying, said = after(at(state), seen(0.0, Order.TAKEOFF, position=UP + 5.0))
    assert flying.state == state
    assert said == [f"takeoff is refused in {state.name}: the robot flies already"]


@pytest.mark.parametrize(
    ("state", "why"),
    [
        (FlightState.ARM_OFF, "start comes first"),
        (FlightState.START, "the flight controller has not confirmed yet that it is armed"),
        (FlightState.STOP, "the flight controller has not confirmed yet that the motors are off"),
    ],
)
def test_takeoff_before_it_is_armed_is_refused(state: FlightState, why: str) -> None:
    flying, said = after(at(state), seen(0.0, Order.TAKEOFF))
    assert flying.state == state
    assert said == [f"takeoff is refused in {state.name}: {why}"]


@pytest.mark.parametrize("way", [(0.31, 0.0, 0.0), (0.22, 0.22, 0.0), (0.0, 0.0, 0.31)])
def test_takeoff_of_a_robot_that_was_moved_stops(way: tuple[float, float, float]) -> None:
    flying, said = after(at(FlightState.ARM_ON), seen(0.0, Order.TAKEOFF, position=HERE + way))
    assert flying.state == FlightState.STOP
    assert "moved by more than 0.3 m" in said[0]
    flying, _ = after(at(FlightState.ARM_ON), seen(0.0, Order.TAKEOFF, position=HERE + 0.9 * np.array(way)))
    assert flying.state == FlightState.TAKEOFF


def test_takeoff_settles_only_near_its_target() -> None:
    flying = at(FlightState.TAKEOFF, settled=0.0)
    for away in ([0.16, 0.0, 0.0], [0.0, -0.16, 0.0], [0.0, 0.0, 0.06]):
        out, _ = after(flying, *(seen(0.2 * k, position=UP + away, target=UP) for k in range(20)))
        assert out.state == FlightState.TAKEOFF
    out, _ = after(flying, seen(1.1, position=None, target=UP))
    assert out.state == FlightState.TAKEOFF


def test_start_needs_a_position_a_battery_and_an_answer() -> None:
    flying, said = after(Flying(), seen(0.0, Order.START, position=None))
    assert flying.state == FlightState.ARM_OFF
    assert "position is not known" in said[0]
    flying, said = after(Flying(), seen(0.0, battery=9.0), seen(3.0, Order.START, battery=9.0))
    assert (flying.state, flying.shown) == (FlightState.ARM_OFF, LOW_BATTERY)
    assert said == ["low battery: 9 per cent", "start is refused: low battery"]
    flying, said = after(at(FlightState.START), seen(5.1))
    assert flying.state == FlightState.STOP
    assert "not acknowledged within 5 s" in said[0]


@pytest.mark.parametrize("state", [FlightState.TAKEOFF, FlightState.HOVER])
def test_low_battery_lands(state: FlightState) -> None:
    dips = seen(1.0, battery=0.0), seen(2.0, battery=80.0), seen(4.1, battery=5.0)
    flying, said = after(at(state), *dips)
    assert (flying.state, said) == (state, [])
    flying, said = after(flying, seen(5.0, battery=10.0), seen(5.1, battery=9.6), seen(8.1, battery=9.8))
    assert (flying.state, flying.shown) == (FlightState.LAND, LOW_BATTERY)
    assert said == ["low battery: 10 per cent", "landing: low battery"]


def test_a_landing_stops_only_a_robot_that_stands() -> None:
    """What stands is what lands behind a link as well: `Standing`; on ROS it is led down, too."""
    landing, below = at(FlightState.LAND), HERE - [0.0, 0.0, 0.2]

    def ended(time: float, **values: Any) -> FlightState:
        """The state after so long of this."""
        ticks = (
            seen(0.01 * k, **{"target": below, "light": True, **values}) for k in range(round(100 * time) + 1)
        )
        return after(landing, *ticks)[0].state

    assert ended(STANDS + 0.01) == FlightState.STOP
    assert ended(STANDS - 0.02) == FlightState.LAND
    assert ended(2.0, light=False) == FlightState.LAND  # its rotors may carry it
    assert ended(2.0, target=HERE) == FlightState.LAND  # on its way back from a surface
    assert ended(2.0, target=None) == FlightState.LAND
    assert ended(2.0, position=None) == FlightState.LAND
    assert ended(2.0, sinking=0.06) == FlightState.LAND


@pytest.mark.parametrize("jump", [0.3, 0.4])
def test_a_robot_that_moved_while_it_seemed_to_stand_has_to_stand_anew(jump: float) -> None:
    """Two looks half a second apart saw one height, and stopped the motors of one that had hopped between."""
    landing, below, ended = at(FlightState.LAND), HERE - [0.0, 0.0, 0.2], 0
    while landing.state == FlightState.LAND:
        hops = [0.0, 0.0, 0.05 if jump <= 0.01 * ended < jump + 0.05 else 0.0]
        landing, _ = after(landing, seen(0.01 * ended, position=HERE + hops, target=below, light=True))
        ended += 1
    assert 0.01 * (ended - 1) == pytest.approx(jump + 0.05 + STANDS, abs=0.015)


def test_a_landing_takes_thrust_away_only_while_it_is_led_down_and_does_not_sink() -> None:
    landing, below = at(FlightState.LAND), UP - [0.0, 0.0, 0.2]
    stays, sinks = seen(0.1, position=UP, target=below), seen(0.2, position=UP, target=below, sinking=0.2)
    assert after(landing, stays)[0].eases
    assert after(landing, replace(stays, sinking=-0.5))[0].eases  # it climbs
    assert not after(landing, stays, sinks)[0].eases
    assert after(landing, stays, sinks, replace(stays, now=0.3))[0].eases
    assert not after(landing, stays, replace(stays, target=UP))[0].eases
    assert not after(landing, stays, replace(stays, target=None))[0].eases  # it goes back from a surface


def test_a_blind_landing_counts_from_when_the_rotors_carry_it_no_more() -> None:
    """What the accelerometer feels, and the time of a fall, say nothing of a robot that hovers by its IMU."""
    blind = at(FlightState.LAND, force_landing=True, blind=0.0, above=0.8)  # 2 s of fall, 5 s at most
    flying, said = after(blind, seen(0.9, position=None, rest=9.0), seen(4.9, position=None))
    assert (flying.state, flying.eases, said) == (FlightState.LAND, False, [])
    flying, said = after(flying, seen(4.9, position=None, rest=9.0))
    assert (flying.state, flying.eases, said) == (FlightState.LAND, True, [])  # does it feel that?
    flying, said = after(flying, seen(5.4, position=None))
    assert (flying.state, flying.eases, said) == (FlightState.LAND, True, [])  # it is high time
    light = [seen(6.0 + 0.6 * k, position=None, rest=9.0, light=True) for k in range(4)]
    flying, said = after(flying, *light[:2])
    assert (flying.state, said) == (FlightState.LAND, [])
    flying, said = after(flying, *light[2:])
    assert (flying.state, said) == (
        FlightState.STOP,
        ["blind landing ends: the accelerometer feels the ground"],
    )
    flying, said = after(blind, *(seen(0.6 * k, position=None, light=True) for k in range(20)))
    assert (flying.state, said) == (FlightState.STOP, ["blind landing ends: it must be down after 5.4 s"])


def test_halt_stops_and_force_landing_shows() -> None:
    for state in FlightState:
        out, _ = after(at(state), seen(0.0, Order.HALT))
        assert out.state == FlightState.STOP
    flying, _ = after(at(FlightState.HOVER), seen(0.0, Order.FORCE_LANDING))
    assert (flying.state, flying.shown, flying.arming) == (
        FlightState.LAND,
        FORCE_LANDING,
        Arming.FORCE_LANDING,
    )
    for state in (FlightState.START, FlightState.ARM_ON, FlightState.STOP):  # it stands
        assert after(at(state), seen(0.0, Order.FORCE_LANDING))[0].state == FlightState.STOP
    flown = Flying(origin=np.zeros(3))  # by this node: the second click finds it disarmed
    assert after(flown, seen(0.0, Order.FORCE_LANDING))[0].state == FlightState.STOP
    left = replace(flown, left=True)
    assert after(left, seen(0.0, Order.FORCE_LANDING))[0].state == FlightState.LAND
    flying, _ = after(Flying(), seen(0.0, Order.FORCE_LANDING, position=None))  # nobody here knows
    assert (flying.state, flying.arming) == (FlightState.LAND, Arming.FORCE_LANDING)
    flying, said = after(at(FlightState.HOVER), seen(0.0, broken="tilt above 1 rad"), seen(0.1, broken="x"))
    assert (flying.shown, said) == (FORCE_LANDING, ["force landing: tilt above 1 rad"])
    flying, _ = after(flying, seen(0.2, Order.HALT), seen(0.3, acknowledged=1))
    assert flying.shown == FlightState.ARM_OFF


def test_land_on_the_ground_disarms() -> None:
    assert after(at(FlightState.ARM_ON), seen(0.0, Order.LAND))[0].state == FlightState.STOP


def test_the_battery_is_read_by_the_labs_table() -> None:
    assert percentage(6 * 4.2, 6) == 100.0
    assert percentage(6 * 3.683, 6) == pytest.approx(10.0)
    assert percentage(6 * 3.446, 6) == pytest.approx(5.0)
    assert percentage(6 * 3.0, 6) == 0.0
    for voltage in (float("nan"), float("inf"), 0.0, -1.0, 6 * 4.36, 2220.0):
        assert np.isnan(percentage(voltage, 6))
    assert np.isnan(percentage(22.2, 4))  # an empty pack of six cells
    assert percentage(6 * 4.35, 6) == 100.0


@pytest.mark.parametrize(
    ("sinks", "carried", "state", "when"),
    [
        (0.0, 0.7, FlightState.STOP, 5),  # it stands, whatever turns its rotors
        (0.0, 0.9, FlightState.LAND, 0),  # it may hover
        (0.15, 0.7, FlightState.LAND, 2),  # it has sunk by 2 cm
        (2.0, 0.7, FlightState.LAND, 0),
    ],
)
def test_a_robot_that_is_found_armed_stands_if_it_does_not_sink_with_too_little_thrust(
    sinks: float, carried: float, state: FlightState, when: int
) -> None:
    told, states = {"armed": True, "carried": carried, "sinking": sinks}, list[FlightState]()
    flying = Flying()
    for k in range(when + 1):
        place = UP - np.array([0.0, 0.0, 0.1 * k * sinks])
        flying, _ = advance(flying, seen(0.1 * k, position=place, **told), LIMITS)
        states.append(flying.state)
    assert states == [FlightState.ARM_OFF] * when + [state]


def test_rotors_that_the_supervisor_has_cut_are_disarmed() -> None:
    flying, said = after(at(FlightState.HOVER), seen(1.0, position=UP, cut=True))
    assert (flying.state, flying.arming) == (FlightState.STOP, Arming.OFF)
    assert said == ["the supervisor has cut the rotors: the flight controller is disarmed"]
    flying, _ = after(flying, seen(2.0), seen(9.0))
    assert flying.arming == Arming.OFF  # until it is acknowledged
    flying, _ = after(flying, seen(9.1, acknowledged=1))
    assert flying.state == FlightState.ARM_OFF
    # The flight controller brings down whom nobody sees.
    flying, _ = after(at(FlightState.LAND, force_landing=True), seen(1.0, position=None, cut=True))
    assert (flying.state, flying.arming) == (FlightState.LAND, Arming.FORCE_LANDING)


@pytest.mark.parametrize(
    ("adopt", "position", "state", "forced"),
    [
        ("land", UP, FlightState.LAND, False),
        ("hover", UP, FlightState.HOVER, False),
        ("hover", None, FlightState.LAND, True),
    ],
)
def test_a_flight_that_somebody_else_began_is_adopted(
    adopt: str, position: np.ndarray | None, state: FlightState, forced: bool
) -> None:
    flying, limits = Flying(), replace(LIMITS, adopt=adopt)
    for k in range(4):
        flying, _ = advance(flying, seen(0.2 * k, position=position, armed=True), limits)
    assert (flying.state, flying.force_landing) == (state, forced)


@pytest.mark.parametrize("known", [False, True])
def test_a_robot_that_somebody_else_commands_is_left_to_it_and_stops_by_order(known: bool) -> None:
    """Two that command one robot lose it. It is taken over once nobody else is there."""
    theirs = {"position": UP, "armed": True, "foreign": ("/base on /h/four_axes/command",)}
    begun = at(FlightState.ARM_OFF) if known else Flying()
    flying, said = after(begun, *(seen(0.2 * k, **theirs) for k in range(20)))
    assert (flying.state, flying.arming) == (FlightState.ARM_OFF, None)
    assert said == [
        "the flight controller is armed, and left to who commands it: /base on /h/four_axes/command"
    ]
    for order, state in ((Order.HALT, FlightState.STOP), (Order.FORCE_LANDING, FlightState.LAND)):
        assert advance(flying, seen(4.0, order, **theirs), LIMITS)[0].state == state
    alone, _ = after(flying, *(seen(4.0 + 0.2 * k, position=UP, armed=True) for k in range(4)))
    assert alone.state == (FlightState.STOP if known else FlightState.LAND)
    _, again = after(flying, seen(4.0, armed=False), seen(5.0, **theirs))
    assert again == said
