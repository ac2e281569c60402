"""A bank of latencies: the one that is true is found from small motions, whatever pushes from outside."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

import skylimb
from skylimb.base.packing import Layout
from skylimb.control.estimation.lateness import BANK, HEARD, WARM, Lateness, lateness
from skylimb.control.estimation.records import BodyState
from skylimb.control.late_gains import MOST

ROBOT, DT, ASSUMED = skylimb.load_robot("hydrus_xi_quad"), 0.005, 0.015
MODEL = ROBOT.at(ROBOT.nominal_posture(), np.zeros(ROBOT.n_vectoring))
INERTIA = np.asarray(MODEL.inertia_C)
STATE = Layout(Lateness())


def stepper() -> ca.Function:
    """A compiled step of the bank: (state, rates that are seen, torque) -> state."""
    flat, seen, torque = ca.SX.sym("state", STATE.size), ca.SX.sym("seen", 3), ca.SX.sym("torque", 3)
    said = ca.SX.sym("said")
    body = BodyState(np.zeros(3), np.zeros(3), np.eye(3), seen, MODEL)
    new = lateness(STATE.unpack(flat), body, torque, ASSUMED, said, 1.0, DT)
    return ca.Function("step", [flat, seen, torque, said], [ca.densify(STATE.pack(new))])


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
        state = STEP(state, seen, torque, said * begun).full().ravel()
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


@pytest.mark.parametrize(("believed", "other", "goes"), [(0.0, 0.05, True), (0.05, 0.0, False)])
def test_stamps_ease_the_way_to_more_latency_alone(believed: float, other: float, goes: bool) -> None:
    """Slow rotors fit a latency that no stamp tells of; it is left on clear evidence alone."""
    misfits = np.full(len(BANK), 1.0)
    misfits[BANK.index(other)] = 0.85  # between the two thresholds
    ready = Lateness(misfits=misfits, late=believed, time=WARM + HEARD)
    state = STEP(STATE.pack(ready), np.zeros(3), np.zeros(3), other).full().ravel()
    assert float(STATE.unpack(state).late) == (other if goes else believed)
