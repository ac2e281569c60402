"""The window of frames: least squares where nothing jumps, one jump where something does."""

from __future__ import annotations

import functools
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np
import pytest

import skylimb
from short_flights import HOLD
from skylimb.base.packing import Layout
from skylimb.control.estimation.moving_window import (
    FRAMES,
    Window,
    WindowGains,
    looked,
    rescaled,
)
from skylimb.flight.drivers.native import compile_native, fly_native
from skylimb.flight.flying import fly_here
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import take_off

DT, MASS = 0.005, 4.0
INERTIA = np.diag([0.1, 0.2, 0.3])
MODEL = SimpleNamespace(mass=MASS, inertia_C=INERTIA)
PLAIN = WindowGains(doubt=1e9)


def body(momentum: np.ndarray) -> Any:
    """A body that has a momentum, (6,)."""
    spin = np.linalg.solve(INERTIA, momentum[3:])
    return SimpleNamespace(model=MODEL, velocity=momentum[:3] / MASS, angular_velocity=spin)


STATE = Layout(Window())


@functools.cache
def compiled(gains: WindowGains) -> ca.Function:
    """A look as one function: (state, momentum, age) -> state."""
    flat, momentum, age = ca.SX.sym("state", STATE.size), ca.SX.sym("momentum", 6), ca.SX.sym("age")
    shown = SimpleNamespace(
        model=MODEL, velocity=momentum[:3] / MASS, angular_velocity=np.linalg.inv(INERTIA) @ momentum[3:]
    )
    made = STATE.pack(looked(gains, STATE.unpack(flat), shown, age, DT))  # type: ignore[arg-type]
    return ca.Function("step", [flat, momentum, age], [ca.densify(made)])


def seen(
    gains: WindowGains, wrench: np.ndarray, noise: float = 0.0, known: np.ndarray | None = None
) -> list[Window]:
    """The window at every tick of frames that come every other tick, 10 ms late, under a wrench."""
    rng, state, found = np.random.default_rng(3), Window(), list[Window]()
    known = np.zeros_like(wrench) if known is None else known
    momentum = np.vstack([np.zeros((1, 6)), np.cumsum(DT * (wrench + known), axis=0)])
    shown = momentum[0]
    for k in range(len(wrench)):
        if k % 2 == 0:
            shown = momentum[max(k - 2, 0)] + noise * rng.normal(size=6)
        made = compiled(gains)(STATE.pack(state), shown, 0.01 + DT * (k % 2))
        state = STATE.unpack(made.full().ravel())
        found.append(state)
        state = state._replace(known_force=known[k, :3], known_torque=known[k, 3:])
    return found


def test_without_jumps_it_is_least_squares_over_the_window() -> None:
    """All noise and drift as unknowns of one dense problem, solved by NumPy, force and torque alike."""
    ticks = 2 * (FRAMES + 15)
    wrench = np.sin(np.arange(ticks)[:, None] * 0.03 + np.arange(6)) * [1, 1, 1, 0.1, 0.1, 0.1]
    state = seen(PLAIN, wrench, 0.002)[-1]
    wanted = []
    for axis in range(6):
        half = axis // 3
        noise, drift = (PLAIN.linear, PLAIN.angular)[half], (PLAIN.force, PLAIN.torque)[half]
        P = state.prior.P[half]
        root = np.linalg.inv(np.linalg.cholesky(np.array([[P[0], P[1]], [P[1], P[2]]])))
        # Unknowns: r of the oldest frame, then f of every frame.
        rows = [np.concatenate([row, np.zeros(FRAMES - 1)]) for row in root]
        values = list(root @ [state.prior.r[axis], state.prior.f[axis]])
        way = np.eye(FRAMES + 1)[0]
        for k in range(FRAMES):
            rows.append(way / noise)
            values.append(state.seen[k][axis] / noise)
            if k < FRAMES - 1:
                way = way + state.spans[k] * np.eye(FRAMES + 1)[1 + k]
                change = np.eye(FRAMES + 1)[2 + k] - np.eye(FRAMES + 1)[1 + k]
                rows.append(change / (drift * np.sqrt(state.spans[k])))
                values.append(0.0)
        wanted.append(np.linalg.lstsq(np.array(rows), np.array(values), rcond=None)[0][-1])
    np.testing.assert_allclose(np.concatenate([state.force, state.torque]), wanted, atol=1e-6)


@pytest.mark.parametrize("axis", [0, 2, 4])
def test_a_touch_is_a_jump(axis: int) -> None:
    """It comes sooner than by the drift alone, at the same noise before it."""
    size = 1.0 if axis < 3 else 0.1
    wrench = np.zeros((400, 6))
    wrench[200:, axis] = size

    def came(gains: WindowGains) -> int:
        made = np.array([np.concatenate([one.force, one.torque])[axis] for one in seen(gains, wrench)])
        assert abs(made[:200]).max() < 1e-9
        return int(np.argmax(made > 0.8 * size))

    few = WindowGains(force=0.1, torque=0.01)
    many = WindowGains(force=0.1, torque=0.01, doubt=1e9)
    assert came(few) < came(many) - 20


def test_what_is_known_to_act_is_no_wrench_whatever_the_frames_age() -> None:
    known = np.random.default_rng(1).normal(size=(200, 6))
    state = seen(WindowGains(), np.zeros((200, 6)), known=known)[-1]
    assert abs(np.concatenate([state.force, state.torque])).max() < 1e-6


def test_a_known_wrench_that_was_greater_all_along_leaves_as_much_less() -> None:
    """The next frames are explained by the rescaled past: nothing moves, and nothing comes later."""
    more = np.array([0.0, 0.0, 0.5, 0.02, 0.0, 0.0])
    wrench = np.tile([0.0, 0.0, 0.5, 0.02, 0.0, 0.0], (300, 1))
    state = seen(WindowGains(), wrench)[-1]
    new = rescaled(state, more, DT)
    new = new._replace(force=state.force - more[:3], torque=state.torque - more[3:])
    momentum = DT * 298 * wrench[0]
    for k in range(40):
        new = new._replace(known_force=more[:3], known_torque=more[3:])
        shown = body(momentum + DT * (k - k % 2) * wrench[0])
        new = looked(WindowGains(), new, shown, 0.01 + DT * (k % 2), DT)
        assert abs(np.concatenate([new.force, new.torque])).max() < 1e-3


def test_compiled_it_makes_the_same() -> None:
    gains, rng, state = WindowGains(), np.random.default_rng(5), Window()
    other = STATE.pack(state)
    for k in range(100):
        given, late = 0.02 * rng.normal(size=6), 0.01 + DT * (k % 2)
        state = looked(gains, state, body(given), late, DT)
        other = compiled(gains)(other, given, late).full().ravel()
    np.testing.assert_allclose(other, STATE.pack(state), atol=1e-9)


def test_as_c_it_passes_its_test_vector(run_as_c: Callable[..., None]) -> None:
    law = {"estimation.law": "moving_horizon"}
    run_as_c(skylimb.load_controller("following", skylimb.load_robot("hydrus_xi_quad"), law))


def test_all_ways_to_fly_it_give_the_same_bits() -> None:
    """And a touch is felt; thrusts that all give more than they are told are learnt as a scale."""
    more = {"controller.estimation.law": "moving_horizon", "plant.thrust_scale": 1.03}
    (takeoff,) = take_off("paper", ("following",), set={**HOLD, **more})
    flight = fly_here(takeoff)
    compile_native(takeoff.tick.function)
    (native,) = fly_native([takeoff], 1)
    np.testing.assert_array_equal(native.signals, flight.signals)
    assert not flight.cause
    assert flight.signal("thrust_scale_estimate")[-1] == pytest.approx(1.03, abs=0.01)
    found = scored_run(takeoff, flight).metrics
    assert found["contact_force_normal_mean"] == pytest.approx(1.0, abs=0.3)
