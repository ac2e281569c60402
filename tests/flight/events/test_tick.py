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
