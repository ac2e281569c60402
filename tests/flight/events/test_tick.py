"""Ticks that come too late: the robot keeps thrusts and set points to the bit, or its supervisor commands."""

import numpy as np
import pytest

from activations import watched
from short_flights import HOLD
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.flying import fly_here
from skylimb.flight.takeoff import take_off


@pytest.mark.parametrize("rotors", ["thrust", "speed"])
def test_thrusts_and_set_points_stand_still_for_so_long(rotors: str) -> None:
    event = {"kind": "tick", "time": 0.9, "duration": 0.1}
    flight, held = watched(1.2, {**HOLD, "events": [event], "plant.rotors": rotors})
    changes = np.abs(np.diff(held, axis=0))
    assert not changes[180:200].any()
    assert (changes[170:179].max(axis=0) > 0.0).all()
    assert (changes[200:].max(axis=0) > 0.0).all()
    assert np.ptp(flight.signal("thrusts_command")[180:200], axis=0).min() > 0.0


def test_rotors_that_keep_their_speed_do_not_turn_the_robot() -> None:
    """The motors hold against drag alone, whatever is commanded meanwhile."""
    event = {"kind": "tick", "time": 0.9, "duration": 0.1}
    (takeoff,) = take_off("paper", ("hybrid",), set={**HOLD, "stop_at": 1.2, "events": [event]})
    flight = fly_here(takeoff)
    drag = np.array([abs(rotor.drag_torque_coefficient) for rotor in takeoff.robot.description.rotors])
    off = np.abs(flight.signal("motor_torques") - drag * flight.signal("thrusts")).max(axis=1)
    assert off[180:200].max() < 1e-12
    assert off[170:180].max() > 1e-3


def test_a_servo_that_runs_away_does_so_without_a_command() -> None:
    """Frozen commands stop every servo, but for the one that runs away by itself."""
    events = [
        {"kind": "joint", "time": 0.5, "duration": 0.6, "joint": "joint2", "speed": 0.3},
        {"kind": "tick", "time": 0.9, "duration": 0.1},
    ]
    _, held = watched(1.2, {**HOLD, "events": events})
    rates = np.diff(held[180:200, 4:7], axis=0) / 0.005
    np.testing.assert_allclose(rates, np.tile([0.0, 0.3, 0.0], (len(rates), 1)), atol=1e-9)


def test_a_supervisor_is_told_and_commands_in_its_place() -> None:
    event = {"kind": "tick", "time": 0.9, "duration": 0.3}
    settings = {**HOLD, "supervisor.on": True, "events": [event]}
    flight, held = watched(1.5, settings)
    mode = flight.signal("supervisor_mode")
    assert not mode[:180].any()
    assert mode[180:240].all()
    assert np.abs(np.diff(held[190:240, :4], axis=0)).max() > 0.0
    (takeoff,) = take_off("paper", ("hybrid",), set=settings)
    compiled, native = fly_here(takeoff), fly_native([takeoff])[0]
    np.testing.assert_array_equal(native.signals[: native.ticks], compiled.signals[: compiled.ticks])
