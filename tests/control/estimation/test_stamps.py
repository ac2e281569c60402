"""Stamps of another clock: steps, freezes, order, leaps; and what age is told of what is believed."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skylimb.control.estimation.stamps import RELOCK, Fault, Stamps, believed, judged

DT = 0.01
"""Between two messages, s."""


class Heard:
    """What became of a row of messages."""

    def __init__(self, messages: Iterable[tuple[float, float]], known: Stamps | None = None) -> None:
        self.known, self.faults, self.ages = known or Stamps(), list[Fault | None](), list[float]()
        for stamp, at in messages:
            self.known, fault = judged(self.known, stamp, at)
            self.faults.append(fault)
            self.ages.append(at - self.known.taken)


def locked(count: int = 100, ahead: float = 1e9) -> Stamps:
    return Heard((ahead + DT * k, DT * k + 0.002) for k in range(count)).known


def test_the_least_delay_is_none_and_the_others_are_later() -> None:
    rng = np.random.default_rng(0)
    delays = rng.uniform(0.002, 0.01, 500)
    heard = Heard((50.0 + DT * k, DT * k + delays[k]) for k in range(500))
    assert not any(heard.faults)
    np.testing.assert_allclose(heard.ages[100:], delays[100:] - delays.min(), atol=3e-4)


@pytest.mark.parametrize("step", [-2.0, -0.3, -0.1, 0.03, 0.3, 2.0, 1e6])
def test_a_clock_that_is_set_is_read_anew(step: float) -> None:
    heard = Heard(((1e9 + 1.0 + step + DT * k, 1.0 + DT * k + 0.002) for k in range(50)), locked(100))
    assert heard.faults[RELOCK - 1] == Fault.STEPPED
    assert not any(believed(fault) for fault in heard.faults[: RELOCK - 1])
    assert not any(heard.faults[RELOCK:])
    assert max(heard.ages) < 0.1  # nothing is held for as long as that
    assert max(heard.ages[RELOCK - 1 :]) < 0.001


def test_many_steps_to_either_side_leave_nothing_behind() -> None:
    known, last = locked(), 0.0
    for turn, step in enumerate([0.3, -2.0, 0.3, 5.0, -0.3, -0.3, 1.0]):
        last, begun = last + step, 1.0 + turn
        heard = Heard(((1e9 + last + begun + DT * k, begun + DT * k + 0.002) for k in range(90)), known)
        known = heard.known
        assert heard.ages[-1] < 0.001


def test_one_wild_or_late_message_is_refused_and_forgotten() -> None:
    known = locked()
    after, fault = judged(known, 1e9 + 500.0, 1.0)
    assert fault == Fault.FUTURE
    assert (after.stamp, after.offset, after.taken) == (known.stamp, known.offset, known.taken)
    after, fault = judged(after, 1e9 + 1.01, 1.012)
    assert fault is None
    assert 1.012 - after.taken < 0.001


def test_repeated_and_overtaken_messages_are_refused_for_ever() -> None:
    twice = [(1e9 + 1.0 + DT * (k // 2), 1.002 + DT * (k // 2)) for k in range(60)]
    assert Counter(Heard(twice, locked()).faults) == {None: 30, Fault.OUT_OF_ORDER: 30}
    swapped = [(1e9 + 1.0 + DT * (k + (1, -1)[k % 2]), 1.002 + DT * k) for k in range(60)]
    assert Counter(Heard(swapped, locked()).faults) == {None: 30, Fault.OUT_OF_ORDER: 30}
    frozen = Heard([(1e9 + 0.99, 1.002 + DT * k) for k in range(60)], locked())
    assert set(frozen.faults) == {Fault.OUT_OF_ORDER}
    assert frozen.ages[-1] > 0.5


def test_old_messages_that_come_in_a_burst_set_no_clock() -> None:
    known = locked()
    burst = [(1e9 + DT * k, 1.0 + 1e-4 * k) for k in range(60)]
    assert Fault.STEPPED not in Heard(burst, known).faults


def test_old_ones_between_good_ones_set_no_clock() -> None:
    row = [(1e9 + 1.0 + DT * k - 0.5 * (k % 2), 1.002 + DT * k) for k in range(200)]
    found = Counter(Heard(row, locked()).faults)
    assert found == {None: 100, Fault.OUT_OF_ORDER: 100}


def test_a_link_that_becomes_slow_makes_old_measurements() -> None:
    """A queue of .2 s is no step of a clock: the stamps go on as they did."""
    slow = Heard([(1e9 + 1.0 + DT * k, 1.2 + DT * k) for k in range(50)], locked())
    assert not any(slow.faults)
    assert min(slow.ages) > 0.19


def test_clocks_may_drift_apart() -> None:
    for drift in (1e-4, -1e-4):
        heard = Heard((1e9 + DT * k * (1.0 + drift), DT * k) for k in range(60_000))
        assert not any(heard.faults)
        assert max(heard.ages) < 0.001


def test_a_first_message_that_was_late_or_wild_is_got_over() -> None:
    for first in (0.5, -3.0):
        row = [(1e9 + first, 0.0), *((1e9 + DT * k, DT * k) for k in range(1, 60))]
        assert Heard(row).ages[-1] < 0.001


def test_no_number_is_no_stamp() -> None:
    for stamp in (math.nan, math.inf, -math.inf):
        assert judged(locked(), stamp, 1.0) == (locked(), Fault.NO_NUMBER)


@given(st.lists(st.tuples(st.floats(), st.floats(0.0, 0.05)), max_size=60))
def test_whatever_comes_nothing_is_from_the_future_and_nothing_grows_younger(
    row: list[tuple[float, float]],
) -> None:
    known, at, taken = Stamps(), 0.0, -math.inf
    for stamp, later in row:
        at += later
        known, fault = judged(known, stamp, at)
        assert taken <= known.taken <= at + 1e-6 * max(1.0, abs(known.stamp)) or not believed(fault)
        taken = known.taken
