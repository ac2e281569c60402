"""A landing is over when the robot is down, and not before: by its height, by its thrusts, or by time."""

from __future__ import annotations

import numpy as np
import pytest

from skylimb.control.supervisor.retreat import retreat_time
from skylimb.flight.realtime.landing import DEPTH, LONGER, Landing, landing_from

DT = 0.01


def ended(landing: Landing, heights: list[float | None], share: float) -> float:
    """The time at which it is over, s; the last height stays."""
    while not landing.over:
        at = min(round(landing.time / DT), len(heights) - 1)
        landing = landing.after(heights[at], share, DT)
    return landing.time


def test_a_robot_that_follows_has_landed_where_its_way_ends() -> None:
    way = list(np.linspace(1.5, -0.1, 800))
    assert ended(landing_from(1.5, 0.0), way, 1.0) == pytest.approx(7.5, abs=0.05)
    # Who is below its floor from the beginning goes back from the surface all the same.
    assert ended(landing_from(0.2, 0.5), [0.2], 1.0) == pytest.approx(retreat_time(-0.3), abs=DT)


def test_a_robot_that_stays_above_the_floor_stands_only_with_low_thrusts() -> None:
    longest = retreat_time(1.0 + DEPTH) + LONGER
    assert ended(landing_from(1.0, 0.0), [0.6], 0.9) == pytest.approx(longest, abs=2 * DT)
    assert ended(landing_from(1.0, 0.0), [0.15], 0.6) == pytest.approx(retreat_time(1.0), abs=2 * DT)
    # It falls: that is not standing, whatever the thrusts are.
    landing = landing_from(1.0, 0.0)._replace(time=10.0)
    for k in range(100):
        landing = landing.after(1.0 - 0.3 * DT * k, 0.3, DT)
        assert not landing.over


def test_of_a_robot_that_nobody_sees_time_alone_is_known() -> None:
    longest = retreat_time(1.0 + DEPTH) + LONGER
    assert ended(landing_from(1.0, 0.0), [None], 0.2) == pytest.approx(longest, abs=2 * DT)
