"""A bank of latencies and lags: what is true is found from small motions, whatever pushes from outside."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

import skylimb
from skylimb.base.packing import Layout
from skylimb.control.estimation.lateness import (
    BANK,
    BENDS,
    PATIENT,
    SLOW,
    WARM,
    Lateness,
    Stamped,
    lateness,
    stamped,
)
from skylimb.control.estimation.records import BodyState
from skylimb.control.supervisor.suited_gains import MOST

ROBOT, DT, ASSUMED, LAG = skylimb.load_robot("hydrus_xi_quad"), 0.005, 0.015, 0.05
MODEL = ROBOT.at(ROBOT.nominal_posture(), np.zeros(ROBOT.n_vectoring))
INERTIA = np.asarray(MODEL.inertia_C)
STATE, STAMPED = Layout(Lateness()), Layout(Stamped())


def stepper() -> ca.Function:
    """A compiled step of the bank: (state, rates that are seen, torque, said, touch) -> state."""
    flat, seen, torque = ca.SX.sym("state", STATE.size), ca.SX.sym("seen", 3), ca.SX.sym("torque", 3)
    said, touch = ca.SX.sym("said"), ca.SX.sym("touch")
    body = BodyState(np.zeros(3), np.zeros(3), np.eye(3), seen, MODEL)
    new = lateness(STATE.unpack(flat), body, torque, ASSUMED, LAG, said, 1.0, touch, DT)
    return ca.Function("step", [flat, seen, torque, said, touch], [ca.densify(STATE.pack(new))])


STEP = stepper()


def found(
    late: float,
    size: float,
    outside: float = 0.0,
    seconds: float = 5.0,
    said: float = 0.0,
    since: float = 0.0,
) -> list[float]:
    """What is believed, tick by tick, of torques like those of hover and gyros that are noisy.

    Args:
        late: how late they are from a moment on, s.
        size: of the torques.
        outside: torque that acts from outside, N m.
        seconds: that all of it lasts.
        said: what the stamps say from that moment on, s.
        since: that moment, s.
    """
    rng, state, believed = np.random.default_rng(4), STATE.pack(Lateness()), []
    torque, rates, past = np.zeros(3), np.zeros(3), [np.zeros(3)] * 40
    for tick in range(round(seconds / DT)):
        past, begun = [rates, *past[:-1]], tick >= round(since / DT)
        seen = past[round((ASSUMED + late * begun) / DT)] + 0.003 * rng.normal(size=3)
        state = STEP(state, seen, torque, said * begun, 0.0).full().ravel()
        believed.append(float(STATE.unpack(state).late))
        torque = 0.95 * torque + size * INERTIA @ (rng.normal(size=3) - 2.0 * rates)
        rates = rates + DT * np.linalg.solve(INERTIA, torque + outside)
    return believed


@pytest.mark.parametrize(("late", "outside"), [*((late, 0.3) for late in BANK), (BANK[2], 0.0)])
def test_a_latency_is_found_from_small_motions(late: float, outside: float) -> None:
    believed = found(late, 0.2, outside)[-200:]
    if late < MOST:
        assert set(believed) == {late}
    else:  # that it is far too late is enough
        assert min(believed) > MOST


def test_nothing_is_said_of_a_robot_that_makes_no_torque() -> None:
    assert set(found(0.1, 0.0)) == {0.0}


def test_what_the_stamps_say_too_is_believed_sooner() -> None:
    alone, agreed = (np.array(found(0.05, 0.2, 0.3, since=2.0, said=said)) for said in (0.0, 0.05))
    first = [int(np.argmax(each == 0.05)) * DT - 2.0 for each in (alone, agreed)]
    assert 0.0 < first[1] < 0.7 * first[0]
    assert set(agreed[round(2.5 / DT) :]) == {0.05}


@pytest.mark.parametrize("said", [-2.0, 0.025, 0.05, 0.1, 0.3, np.nan])
def test_stamps_alone_prove_nothing(said: float) -> None:
    assert set(found(0.0, 0.2, 0.3, said=said)) == {0.0}
    assert set(found(0.0, 0.0, said=said)) == {0.0}
    step = STEP(STATE.pack(Lateness()), np.full(3, 0.1), np.full(3, 0.1), said, 0.0)
    assert np.isfinite(step.full()).all()


@pytest.mark.parametrize(("believed", "other", "goes"), [(0.0, 0.05, True), (0.05, 0.0, False)])
def test_stamps_ease_the_way_to_more_latency_alone(believed: float, other: float, goes: bool) -> None:
    """Slow rotors fit a latency that no stamp tells of; it is left on clear evidence alone."""
    misfits = np.full(len(BANK) + len(SLOW), 1.0)
    misfits[BANK.index(other)] = 0.85  # between the two thresholds
    ready = Lateness(misfits=misfits, late=believed, time=WARM + PATIENT)
    state = STEP(STATE.pack(ready), np.zeros(3), np.zeros(3), other, 0.0).full().ravel()
    assert float(STATE.unpack(state).late) == (other if goes else believed)


def slowness(
    slow: float, *, late: float = 0.0, said: float = 0.0, touched: bool = False
) -> tuple[float, float]:
    """What is believed of lag and latency after five seconds of a robot whose rotors are slower, s.

    Args:
        slow: by how much more than assumed they lag, s.
        late: how much later than assumed its measurements are, beside what its arm makes of that, s.
        said: what the stamps say, s.
        touched: whether its tip is to touch.
    """
    rng, state = np.random.default_rng(4), STATE.pack(Lateness())
    command, made, modelled, rates, past = (
        np.zeros(3),
        np.zeros(3),
        np.zeros(3),
        np.zeros(3),
        [np.zeros(3)] * 40,
    )
    believed = Lateness()
    for _ in range(round(5.0 / DT)):
        past = [rates, *past[:-1]]
        seen = past[round((ASSUMED + BENDS + late) / DT)] + 0.003 * rng.normal(size=3)
        state = STEP(state, seen, modelled, said, float(touched)).full().ravel()
        believed = STATE.unpack(state)
        command = 0.95 * command + 0.2 * INERTIA @ (rng.normal(size=3) - rates)
        made = made + (1.0 - np.exp(-DT / (LAG + slow))) * (command - made)
        modelled = modelled + (1.0 - np.exp(-DT / (LAG + float(believed.slow)))) * (command - modelled)
        rates = rates + DT * np.linalg.solve(INERTIA, made)
    return float(believed.slow), float(believed.late)


@pytest.mark.parametrize("slow", SLOW)
def test_slow_rotors_are_found_where_frames_are_in_time(slow: float) -> None:
    found, late = slowness(slow)
    assert found == slow
    assert late < MOST


def test_slow_rotors_are_not_looked_for_where_the_stamps_tell_of_latency_or_the_tip_touches() -> None:
    assert slowness(0.05, said=0.05)[0] == 0.0
    assert slowness(0.05, touched=True)[0] == 0.0
    found, late = slowness(0.0, late=0.05, said=0.05)
    assert found == 0.0
    assert late > 0.0


def judge() -> ca.Function:
    """A compiled step of what stamps say: (state, age of the newest frame) -> (state, what is believed)."""
    flat, age = ca.SX.sym("state", STAMPED.size), ca.SX.sym("age")
    state, late = stamped(STAMPED.unpack(flat), age, 1.0, DT)
    return ca.Function("judge", [flat, age], [ca.densify(STAMPED.pack(state)), ca.densify(late)])


JUDGE = judge()


def by_stamps(made: np.ndarray, came: np.ndarray, until: float, steps: dict[float, float]) -> np.ndarray:
    """What is believed at each tick of frames that were made and came at these times, s.

    Args:
        made: when each was.
        came: when each did, in the same order.
        until: the last tick, s.
        steps: by how much the stamps' clock is set back, s, from when on.
    """
    now = np.arange(0.0, until, DT)
    newest = np.searchsorted(came, now + 1e-9, side="right") - 1
    off = sum(step * (at <= now + 1e-9) for at, step in steps.items())
    ages = (now - made[newest] + off)[newest >= 0]
    _, late = JUDGE.mapaccum(len(ages))(STAMPED.pack(Stamped()), ages[None])
    return late.full().ravel()


@pytest.mark.parametrize("rate", [200.0, 100.0, 60.0, 30.0, 10.0])
@pytest.mark.parametrize("latency", [0.0, 0.01, 0.1])
@pytest.mark.parametrize("step", [0.0, 0.3, -0.3, 2.0])
def test_by_stamps_nothing_is_late_that_always_was_nor_what_a_clock_says_that_was_set(
    rate: float, latency: float, step: float
) -> None:
    rng, made = np.random.default_rng(0), np.arange(0.0, 4.0, 1.0 / rate)
    came = np.maximum.accumulate(made + latency + rng.uniform(0.0, 0.01, len(made)))
    assert not by_stamps(made, came, 4.0, {2.0: step, 3.0: -step}).any()


def test_by_stamps_frames_that_do_not_come_for_a_while_are_none_that_come_late() -> None:
    made = np.arange(0.0, 4.0, 0.01)
    made = made[(made <= 1.0) | (made >= 1.5)]
    assert not by_stamps(made, made + 0.01, 4.0, {}).any()


@pytest.mark.parametrize("rate", [200.0, 100.0, 30.0])
@pytest.mark.parametrize(("late", "believed"), [(0.02, 0.0), (0.05, 0.05), (0.075, 0.075), (0.1, 0.1)])
def test_by_stamps_frames_that_come_later_are_believed_to_and_in_time_again(
    rate: float, late: float, believed: float
) -> None:
    made = np.arange(0.0, 6.0, 1.0 / rate)
    came = made + 0.01 + np.where((made > 2.0) & (made < 4.0), late, 0.0)
    order = np.maximum.accumulate(came)
    # Of a clock that is set nobody knows how far into a frame's time it was: with seldom frames that is much.
    found = by_stamps(made, order, 6.0, {3.0: 0.3 if rate > 50.0 else 0.0})
    at = {
        now: found[round(now / DT) - len(np.arange(0.0, 6.0, DT)) + len(found)]
        for now in (1.9, 2.6, 3.9, 5.5)
    }
    assert at == {1.9: 0.0, 2.6: believed, 3.9: believed, 5.5: 0.0}
    assert found.max() == believed


@pytest.mark.parametrize("bad", [np.nan, 1e9, -1e9, 1e300])
def test_a_stamp_that_is_no_number_says_nothing(bad: float) -> None:
    state = Stamped()
    for k in range(400):
        state, late = stamped(state, bad if k % 7 == 3 else 0.01, 1.0, DT)
        assert late == 0.0
