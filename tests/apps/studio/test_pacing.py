"""Ticks are flown when they are due."""

import pytest

from skylimb.apps.studio.pacing import LATE, LEAD, Pacing
from skylimb.base.errors import ConfigError


class Clock:
    """A wall clock that goes on when it is told."""

    def __init__(self):
        self.now = 0.0

    def __call__(self):
        return self.now


@pytest.mark.parametrize("speed", [0.1, 1.0, 7.0])
def test_as_many_ticks_are_flown_as_time_goes_by(speed):
    clock, flown = Clock(), []
    pacing = Pacing(0.005, clock)
    pacing.speed = speed

    def advance(ticks):
        flown.append(ticks)
        return ticks

    for _ in range(4000):
        clock.now += 0.0013
        pacing.fly(advance)
    assert sum(flown) == pytest.approx(1 + (4000 * 0.0013 + LEAD) * speed / 0.005, abs=1.5)
    assert pacing.reached == pytest.approx(speed, rel=0.05)
    assert pacing.late == 0


def test_what_a_slow_flight_lags_behind_is_forgotten_and_counted():
    clock = Clock()
    pacing = Pacing(0.005, clock)

    def advance(ticks):
        clock.now += 0.01 * ticks
        return ticks

    for _ in range(300):
        pacing.fly(advance)
        clock.now += 1e-4
    assert pacing.reached == pytest.approx(0.5, rel=0.1)
    assert pacing.late > 0
    clock.now += 5.0
    before = pacing.flown
    pacing.fly(advance)
    assert pacing.flown - before < 60


def test_a_flight_that_does_not_go_on_begins_a_new_schedule():
    clock = Clock()
    pacing = Pacing(0.005, clock)
    clock.now = 3.0
    assert pacing.fly(lambda ticks: 0) == 0
    clock.now = 3.006
    assert pacing.fly(lambda ticks: ticks) == 2 + LEAD / 0.005
    assert 0.0 < pacing.wait <= 0.005


@pytest.mark.parametrize(("pause", "late"), [(LEAD + 0.9 * LATE, 0), (LEAD + 1.1 * LATE, 1)])
def test_what_was_flown_ahead_covers_a_busy_moment(pause, late):
    clock = Clock()
    pacing = Pacing(0.005, clock)
    pacing.fly(lambda ticks: ticks)
    clock.now = pause + 0.005
    pacing.fly(lambda ticks: ticks)
    assert pacing.late == late


def test_a_speed_beyond_what_can_be_is_refused():
    with pytest.raises(ConfigError, match=r"outside of 0\.1 \.\. 20"):
        Pacing(0.005).speed = 21.0


def test_a_flight_that_was_held_up_has_not_gone_faster_since():
    clock, shown = Clock(), []
    pacing = Pacing(0.005, clock)
    for wait in (*[0.005] * 400, 5.0, *[0.005] * 400):
        clock.now += wait
        pacing.fly(lambda ticks: ticks)
        shown.append(pacing.reached)
    assert max(shown[20:]) < 1.1
    assert shown[-1] == pytest.approx(1.0, rel=0.02)
