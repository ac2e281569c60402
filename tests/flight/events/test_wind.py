"""Wind pushes by its drag; a gust's impulse is that of its profile."""

from itertools import pairwise

import numpy as np
import pytest

from short_flights import HOLD
from skylimb.flight.events import Wind
from skylimb.flight.takeoff import take_off

VELOCITY = (3.0, 4.0, 0.0)


@pytest.mark.parametrize(("profile", "share"), [("gust", 3.0 / 8.0), ("steady", 1.0)])
def test_its_impulse_is_that_of_its_drag(profile: str, share: float) -> None:
    event = {"kind": "wind", "time": 0.5, "duration": 1.0, "velocity": VELOCITY, "profile": profile}
    (takeoff,) = take_off("paper", ("hybrid",), set={**HOLD, "events": [{**event, "drag_area": 0.1}]})
    wrenches = takeoff.timeline(takeoff.times).wrenches
    impulse = sum(0.005 * (one.end - one.begin) * np.array(one.force) for one in wrenches)
    greatest = 0.5 * 1.225 * 0.1 * 25.0 * np.array([0.6, 0.8, 0.0])
    np.testing.assert_allclose(impulse, share * greatest, rtol=1e-3)
    ticks = sorted({(one.begin, one.end) for one in wrenches})
    assert all(end == begin for (_, end), (begin, _) in pairwise(ticks))
    assert len({one.body for one in wrenches}) > 4  # it blows on all links


def test_it_says_how_hard_it_pushes() -> None:
    assert Wind(1.0, VELOCITY, duration=1.0, drag_area=0.1).words == "wind of 5 m/s, 1.53 N"
