"""Latency and rotor lag against what a rigid body and a first-order lag really do."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skylimb.errors import ConfigError
from skylimb.estimation.delay import (
    DEPTH,
    DelayCompensation,
    DelayState,
    delayed_wrench,
    initial_delay_state,
    lead_thrusts,
    predict,
    remember,
    require_history,
)
from skylimb.estimation.records import BodyState, Wrench
from skylimb.spatial import rotation_from_rpy

DT = 0.005
MASS, INERTIA = 4.0, np.diag([0.1, 0.2, 0.3])
ACTING = np.array([1.0, -2.0, 3.0, 0.05, -0.02, 0.03])
FORCE, TORQUE = np.array([0.5, 0.0, -1.0]), np.array([0.0, 0.01, 0.02])


def body(**changes: Any) -> BodyState:
    model: Any = SimpleNamespace(mass=MASS, inertia_C=INERTIA)
    values = {
        "position": np.zeros(3),
        "velocity": np.zeros(3),
        "R_WC": np.eye(3),
        "angular_velocity": np.zeros(3),
    }
    return BodyState(**{**values, **changes}, model=model)


@pytest.mark.parametrize("latency", [0.0, 0.004, 0.02, 0.0225, 0.07])
def test_the_prediction_is_exact_for_a_constant_acceleration(latency: float) -> None:
    state = DelayState(np.zeros(4), (ACTING,) * DEPTH)
    position, velocity = np.array([1.0, 2.0, 3.0]), np.array([0.1, -0.2, 0.3])
    measured = body(position=position, velocity=velocity)
    now = predict(DelayCompensation(latency=latency), state, measured, Wrench(FORCE, np.zeros(3)), DT)
    a = (ACTING[:3] + FORCE) / MASS
    np.testing.assert_allclose(now.velocity, velocity + latency * a, atol=1e-12)
    np.testing.assert_allclose(now.position, position + latency * velocity + 0.5 * latency**2 * a, atol=1e-12)


@pytest.mark.parametrize("latency", [0.004, 0.02, 0.0225])
def test_attitude_is_predicted_about_one_axis_up_to_third_order(latency: float) -> None:
    state = DelayState(np.zeros(4), (np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.06]),) * DEPTH)
    torque, spin = np.array([0.0, 0.0, 0.03]), np.array([0.0, 0.0, 0.4])
    start = rotation_from_rpy(0.1, -0.2, 0.5)
    measured = body(R_WC=start, angular_velocity=spin)
    now = predict(DelayCompensation(latency=latency), state, measured, Wrench(np.zeros(3), torque), DT)
    turned = 0.4 * latency + 0.5 * latency**2 * 0.3
    np.testing.assert_allclose(now.angular_velocity, [*spin[:2], spin[2] + latency * 0.3], atol=1e-12)
    wanted = start @ rotation_from_rpy(0.0, 0.0, turned)
    np.testing.assert_allclose(now.R_WC, wanted, atol=turned**3)
    np.testing.assert_allclose(now.R_WC.T @ now.R_WC, np.eye(3), atol=1e-12)


def test_a_force_that_changed_counts_from_when_it_did() -> None:
    # For the last two ticks 4 N, before nothing; 3.5 ticks of latency.
    push, none = np.array([4.0, 0, 0, 0, 0, 0]), np.zeros(6)
    state = initial_delay_state(np.zeros(4))
    for wrench in (none, push, push):
        state = remember(state, np.zeros(4), wrench)
    now = predict(DelayCompensation(latency=3.5 * DT), state, body(), Wrench(np.zeros(3), np.zeros(3)), DT)
    assert now.velocity[0] == pytest.approx(2 * DT)
    assert now.position[0] == pytest.approx(0.5 * (2 * DT) ** 2)


@given(st.floats(0.0, DEPTH - 1.0))
def test_the_delayed_wrench_lies_between_two_ticks(ticks: float) -> None:
    state = DelayState(np.zeros(4), tuple(np.full(6, float(i)) for i in range(DEPTH)))
    found = delayed_wrench(DelayCompensation(latency=ticks * DT), state, DT)
    np.testing.assert_allclose(found, ticks, atol=1e-9)


def test_a_measurement_older_than_the_history_is_not_taken_for_free_fall() -> None:
    state = DelayState(np.zeros(4), (ACTING,) * DEPTH)
    found = delayed_wrench(DelayCompensation(latency=0.15), state, DT)
    np.testing.assert_allclose(found, ACTING)
    require_history(DelayCompensation(compensate=True, latency=0.07), DT)
    require_history(DelayCompensation(compensate=False, latency=0.2), DT)
    with pytest.raises(ConfigError, match=r"delay.latency = 0.02 s .* 16 ticks of 0.001 s"):
        require_history(DelayCompensation(compensate=True, latency=0.02), 0.001)


def test_the_lead_makes_a_first_order_lag_faster() -> None:
    gains = DelayCompensation(rotor_lag=0.05, lead=2.0)
    wish, low, high = np.array([10.0]), np.array([0.0]), np.array([30.0])
    state, thrust, fine = initial_delay_state(np.array([5.0])), 5.0, 200
    decay = np.exp(-DT / fine / 0.05)
    found = []
    for _ in range(40):
        command, mean, end = lead_thrusts(gains, state, wish, low, high, DT)
        # The rotors as they are, in small steps.
        total = 0.0
        for _ in range(fine):
            after = command[0] + (thrust - command[0]) * decay
            total += 0.5 * (thrust + after)
            thrust = after
        assert end[0] == pytest.approx(thrust, abs=1e-9)
        assert mean[0] == pytest.approx(total / fine, abs=1e-5)
        state = remember(state, end, np.zeros(6))
        found.append(thrust)
    # Twice as fast: what is missing decays as exp(-2 t / lag) does, up to the tick's own length.
    missing = (10.0 - np.array(found)) / 5.0
    np.testing.assert_allclose(missing, np.exp(-2.0 * DT / 0.05 * np.arange(1, 41)), atol=0.02)


def test_the_command_stays_within_the_limits_and_the_model_knows_it() -> None:
    state = initial_delay_state(np.array([5.0]))
    command, _, end = lead_thrusts(
        DelayCompensation(lead=10.0), state, np.array([20.0]), np.array([1.0]), np.array([12.0]), DT
    )
    assert command[0] == 12.0
    assert 5.0 < end[0] < 12.0


@pytest.mark.parametrize("lag", [1e-4, 0.001, 0.005])
def test_rotors_without_a_lag_are_not_led_into_ringing(lag: float) -> None:
    state, wish = initial_delay_state(np.array([5.0])), np.array([10.0])
    end = np.zeros(1)
    for _ in range(10):
        _, _, end = lead_thrusts(
            DelayCompensation(rotor_lag=lag, lead=3.0), state, wish, np.zeros(1), np.full(1, 30.0), DT
        )
        assert end[0] <= 10.0 + 1e-9
        state = remember(state, end, np.zeros(6))
    assert end[0] == pytest.approx(10.0, abs=1e-6)
