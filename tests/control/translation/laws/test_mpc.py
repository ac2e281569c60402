"""Plans over a horizon: least cost by an independent solver, within their limits, and in flight."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import expm, solve_discrete_are

import skylimb
from short_flights import HOLD
from skylimb.base.errors import ConfigError
from skylimb.base.packing import numeric
from skylimb.control.box_least_squares import nearest_in_box
from skylimb.control.estimation.records import Start
from skylimb.control.laws.user_functions import Prepared
from skylimb.control.records import LawInput
from skylimb.control.supervisor.table import TABLE
from skylimb.control.translation.horizon import STAGE, STAGES, Axis, free_moves, held, plan
from skylimb.control.translation.laws import mpc
from skylimb.flight.drivers.native import compile_native, fly_native
from skylimb.flight.flying import fly_here
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import take_off

RATE = 20.0
AXES = [Axis(0.1, 1.0, 0.0, (300.0, 10.0)), Axis(0.05, 12.0, 1.0, (10.0, 10.0))]


@pytest.mark.parametrize("axis", AXES, ids=["place", "force"])
@pytest.mark.parametrize("limit", [1e3, 0.6])
def test_a_plan_costs_least(axis: Axis, limit: float) -> None:
    """A programme with every state as an unknown, solved by another method, has the same moves."""
    rng = np.random.default_rng(7)
    constants = plan(axis)
    rates = np.array([[0.0, axis.gain, 0.0], [-axis.back, 0.0, 1.0], [0.0, 0.0, -1.0 / axis.lag]])
    whole = np.zeros((4, 4))
    whole[:3, :3], whole[2, 3] = rates, 1.0 / axis.lag
    whole = expm(STAGE * whole)
    F, g = whole[:3, :3], whole[:3, 3]
    np.testing.assert_allclose(np.column_stack(held(axis)), np.column_stack([F, g]), atol=1e-12)
    Q = np.diag([*axis.cost, 0.0])
    P = solve_discrete_are(F, g[:, None], Q, np.eye(1))
    for _ in range(5):
        x0, path = rng.normal(size=3), rng.normal() * np.ones(STAGES + 1)  # a place that is kept
        opti = ca.Opti("conic")
        x, u = opti.variable(3, STAGES + 1), opti.variable(STAGES)
        opti.subject_to(x[:, 0] == x0)
        cost, push = ca.MX(0), axis.back * path[0]
        for k in range(STAGES):
            opti.subject_to(x[:, k + 1] == ca.DM(F) @ x[:, k] + ca.DM(g) * u[k])
            off = x[:, k + 1] - np.array([path[0], 0.0, push])
            cost += (u[k] - push) ** 2 + ca.bilin(ca.DM(P if k == STAGES - 1 else Q), off, off)
        opti.subject_to(opti.bounded(-limit, u, limit))
        opti.minimize(cost)
        opti.solver("qrqp", {"print_iter": False, "print_header": False, "print_info": False})
        least = opti.solve().value(u)
        free = free_moves(constants, x0, path, 0.0)
        found, _ = nearest_in_box(STAGES, STAGES)(constants.cost, free, -limit, limit)
        np.testing.assert_allclose(found.full().ravel(), least, atol=2e-5)


def test_a_path_that_moves_evenly_is_followed_without_an_error() -> None:
    """On a straight path at its speed, at its place, nothing has to be done."""
    speed = 0.3
    path = speed * STAGE * np.arange(STAGES + 1)
    free = free_moves(plan(AXES[0]), np.array([0.0, speed, 0.0]), path, speed)
    np.testing.assert_allclose(free, 0.0, atol=1e-9)


def test_it_draws_and_presses_and_all_drivers_fly_the_same_bits() -> None:
    (takeoff,) = take_off("paper", ("mpc",), 0, {"trajectory.period": 8.0, "phases.hover": 1.0})
    flight = fly_here(takeoff)
    assert not flight.cause
    compile_native(takeoff.tick.function)
    (native,) = fly_native([takeoff], 1)
    np.testing.assert_array_equal(native.signals, flight.signals)
    metrics = scored_run(takeoff, flight).metrics
    assert metrics["contact_fraction"] > 0.98
    assert metrics["pen_line_rms"] < 0.02
    assert metrics["contact_force_normal_mean"] == pytest.approx(1.0, abs=0.1)


def test_no_plan_goes_beyond_its_limits() -> None:
    """A step of the place that wants far more than the tilt that is allowed."""
    tilt = 0.03
    push = {"kind": "push", "time": 1.0, "duration": 0.5, "force": [0.0, 6.0, 0.0]}
    limits = {"controller.translation.tilt": tilt, "controller.translation.rate": RATE}
    log = skylimb.run("paper", "mpc", set={**HOLD, **limits, "events": [push]}).log
    moves = np.abs(log["planned_moves"].values)
    most = 9.80665 * np.array([np.tan(tilt), np.tan(tilt), 0.3])
    assert (moves <= most + 1e-9).all()
    assert moves[:, 1].max() == pytest.approx(most[1])
    assert not log["plan_age"].values.any()
    change = np.abs(np.diff(log["planned_moves"].values, axis=0))
    assert change.max() == pytest.approx(RATE * 0.005)


def test_where_no_plan_is_found_the_last_one_goes_on(
    make_inputs: Callable[..., LawInput], make_start: Callable[..., Start]
) -> None:
    gains = mpc.Gains(rate=RATE)
    prepared = Prepared(numeric(gains), mpc.prepare(gains, skylimb.load_robot("hydrus_xi_quad")))
    state, off = mpc.initial_state(gains, make_start()), make_inputs(position=np.array([0.0, 0.05, 0.0]))
    for _ in range(40):
        state, *_ = mpc.step(prepared, state, off)
    kept, row = state.plan, state.plan[STAGES : 2 * STAGES]
    wrong = np.full(3, np.nan)
    for k in range(1, 301):
        state, force, signals = mpc.step(prepared, state, make_inputs(position=wrong, force=wrong))
        assert signals["plan_age"] == pytest.approx(k * 0.005)
        assert np.isfinite(force).all() == (k <= 200)  # after its second it commands no number
        if k == 60:
            assert signals["planned_moves"][1] == pytest.approx(row[3])  # of 0.3 s later
        if k == 200:
            assert force[1] == pytest.approx(4.0 * row[-1])
    np.testing.assert_array_equal(state.plan, kept)
    assert mpc.step(prepared, state, off)[2]["plan_age"] == 0.0


PLANLESS = """
import numpy as np

from skylimb.control.translation.laws import mpc
from skylimb.control.translation.laws.mpc import OPTIONAL, REQUIRES, Gains, initial_state, needs, prepare
from skylimb.symbolic import where


def step(gains, state, inputs, plans):
    rate = where(inputs.reference.touch > 0.5, np.nan * np.ones(3), inputs.reference.tip_velocity)
    wrong = inputs._replace(reference=inputs.reference._replace(tip_velocity=rate))
    return mpc.step((gains, plans), state, wrong)
"""


def test_a_plan_that_has_run_out_is_the_supervisors_turn(tmp_path: Path) -> None:
    """No plan is found where the pen should touch: the last one for a second, then back from the surface."""
    (tmp_path / "planless.py").write_text(PLANLESS, encoding="utf-8")
    law = {"controller.translation.law": str(tmp_path / "planless.py")}
    log = skylimb.run("paper", "mpc", set={"trajectory.period": 8.0, "phases.hover": 1.0, **law}).log
    age, mode = log.plan_age.values, log.supervisor_mode.values
    first = int(np.argmax(age > 0.0))
    said = [
        name
        for place, name in enumerate(TABLE.bits)
        if any(log.supervisor_bits.values.astype(int) >> place & 1)
    ]
    assert not mode[: first + 200].any()
    assert mode[first + 202] == TABLE.mode("COAST")
    assert mode[first + 310] == TABLE.mode("RETREAT")
    assert {"late", "silent"} <= set(said)
    assert np.isfinite(log.thrusts_command.values).all()
    assert log.contact_force.values[-1] == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [("tilt", 2.0, "tilt = 2 rad"), ("lag", [0.0, 0.1, 0.1], "lag"), ("force_cost", -1.0, "force_cost")],
)
def test_gains_out_of_range_are_refused(key: str, value: Any, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        skylimb.load_controller("mpc", skylimb.load_robot("hydrus_xi_quad"), {f"translation.{key}": value})


def test_as_c_it_passes_its_test_vector(run_as_c: Callable[..., None]) -> None:
    run_as_c(skylimb.load_controller("mpc", skylimb.load_robot("hydrus_xi_quad")))
