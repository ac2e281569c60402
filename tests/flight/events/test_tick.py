"""Commands that never arrive: the robot keeps thrusts and set points to the bit, whatever it is told."""

import numpy as np
import pytest

from activations import watched
from short_flights import HOLD


@pytest.mark.parametrize("rotors", ["thrust", "speed"])
def test_thrusts_and_set_points_stand_still_for_so_long(rotors: str) -> None:
    event = {"kind": "tick", "time": 0.9, "duration": 0.1}
    flight, held = watched(1.2, {**HOLD, "events": [event], "plant.rotors": rotors})
    changes = np.abs(np.diff(held, axis=0))
    assert not changes[180:200].any()
    assert (changes[170:179].max(axis=0) > 0.0).all()
    assert (changes[200:].max(axis=0) > 0.0).all()
    assert np.ptp(flight.signal("thrusts_command")[180:200], axis=0).min() > 0.0
