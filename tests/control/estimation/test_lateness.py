"""A bank of latencies: the one that is true is found from small motions, whatever pushes from outside."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

import skylimb
from skylimb.base.packing import Layout
from skylimb.control.estimation.lateness import BANK, Lateness, lateness
from skylimb.control.estimation.records import BodyState
from skylimb.control.late_gains import MOST

ROBOT, DT, ASSUMED = skylimb.load_robot("hydrus_xi_quad"), 0.005, 0.015
MODEL = ROBOT.at(ROBOT.nominal_posture(), np.zeros(ROBOT.n_vectoring))
INERTIA = np.asarray(MODEL.inertia_C)
STATE = Layout(Lateness())


def stepper() -> ca.Function:
    """A compiled step of the bank: (state, rates that are seen, torque) -> state."""
    flat, seen, torque = ca.SX.sym("state", STATE.size), ca.SX.sym("seen", 3), ca.SX.sym("torque", 3)
    body = BodyState(np.zeros(3), np.zeros(3), np.eye(3), seen, MODEL)
    new = lateness(STATE.unpack(flat), body, torque, ASSUMED, 1.0, DT)
    return ca.Function("step", [flat, seen, torque], [ca.densify(STATE.pack(new))])


STEP = stepper()


def found(late: float, size: float, outside: float = 0.0, seconds: float = 5.0) -> list[float]:
    """What is believed, tick by tick, of torques like those of hover and gyros that are noisy."""
    rng, state, believed = np.random.default_rng(4), STATE.pack(Lateness()), []
    torque, rates, past = np.zeros(3), np.zeros(3), [np.zeros(3)] * 40
    for _ in range(round(seconds / DT)):
        past = [rates, *past[:-1]]
        seen = past[round((ASSUMED + late) / DT)] + 0.003 * rng.normal(size=3)
        state = STEP(state, seen, torque).full().ravel()
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
