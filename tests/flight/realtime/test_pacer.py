"""Deadlines that count from the start, and how a flight kept to them."""

import json

import numpy as np
import pytest

from skylimb.flight.realtime.pacer import Pacer
from skylimb.flight.realtime.timing import Timing, bare_timing


class Clock:
    """A clock that goes on when somebody sleeps, and a little when it is read."""

    def __init__(self, oversleep: float = 0.0) -> None:
        self.time, self.oversleep, self.slept = 0, oversleep, 0

    def now(self) -> int:
        self.time += 100
        return self.time

    def sleep(self, seconds: float) -> None:
        assert seconds > 0.0
        self.time += round((seconds + self.oversleep) * 1e9)
        self.slept += 1


def test_a_late_tick_delays_none_of_those_after_it() -> None:
    clock = Clock()
    pacer = Pacer(0.005, clock.now, clock.sleep)
    pacer.start()
    start = clock.time
    for k in range(5):
        assert pacer.wait(k) < 1e-6
    clock.time += 13_000_000  # 2.6 ticks of work
    late = [pacer.wait(k) for k in range(5, 10)]
    assert late == pytest.approx([0.008, 0.003, 0.0, 0.0, 0.0], abs=2e-6)
    assert clock.time - start == pytest.approx(9 * 5_000_000, abs=1000)


def test_a_tick_is_missed_when_the_next_one_is_due() -> None:
    clock = Clock()
    pacer = Pacer(0.005, clock.now, clock.sleep)
    pacer.start()
    pacer.wait(0)
    clock.time += 9_000_000
    pacer.wait(1)
    assert not pacer.missed
    assert pacer.late == pytest.approx(0.004, abs=1e-6)
    clock.time += 7_000_000
    pacer.wait(2)
    assert pacer.missed
    assert pacer.elapsed() == pytest.approx(0.006, abs=1e-6)


def test_a_sleeper_that_is_woken_late_is_in_time_as_it_waits_awake() -> None:
    clock = Clock(oversleep=0.0002)
    pacer = Pacer(0.005, clock.now, clock.sleep, spin=0.0003)
    pacer.start()
    assert max(pacer.wait(k) for k in range(100)) < 1e-6
    assert clock.slept == 99


def test_a_start_can_lie_ahead() -> None:
    clock = Clock()
    pacer = Pacer(0.005, clock.now, clock.sleep)
    pacer.start(1.0)
    pacer.wait(0)
    assert clock.time == pytest.approx(1e9, abs=1000)


def test_real_ticks_do_not_drift() -> None:
    timing = bare_timing(0.002, 100)
    assert (timing.late >= 0.0).all()
    assert timing.late[-50:].min() < 0.002  # one tick in time near the end: lateness does not add up
    assert not timing.held.any()


def test_what_is_said_of_a_flight() -> None:
    late = np.array([1e-6] * 989 + [2e-4] * 10 + [0.02])
    latency, held = late + 4e-4, np.arange(1000) == 999
    timing = Timing(0.005, late, latency, held)
    assert timing.overruns == 1
    assert timing.kept
    assert timing.verdict() == "kept up: 1 of 1000 ticks overran their 5 ms, 1 were held"
    quantiles = timing.quantiles()
    assert quantiles["jitter"]["p50"] == 1e-6
    assert quantiles["latency"]["worst"] == pytest.approx(0.0204)
    assert list(quantiles["jitter"]) == ["p50", "p99", "p99.9", "worst"]
    histogram = {words: (a, b) for words, a, b in timing.histogram()}
    assert histogram["0 .. 10 us"] == (989, 0)
    assert histogram["200 .. 500 us"] == (10, 989)
    assert histogram["over 10000 us"] == (1, 1)
    assert sum(a for a, _ in histogram.values()) == 1000
    slow = Timing(0.005, late, latency + 0.005, held)
    assert slow.verdict().startswith("this machine cannot keep 200 Hz: 1000 of 1000 ticks overran")
    assert json.dumps(timing.quantiles())
