"""Latency against what a rigid body really does."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skylimb.base.errors import ConfigError
from skylimb.base.rotations import rotation_from_rpy
from skylimb.control.estimation.delay import (
    DEPTH,
    Delay,
    DelayState,
    delayed_wrench,
    predict,
    remember,
    require_history,
)
from skylimb.control.estimation.records import BodyState, Wrench
from skylimb.robots.description import GRAVITY

G = np.array([0.0, 0.0, GRAVITY])

DT = 0.005
MASS, INERTIA = 4.0, np.diag([0.1, 0.2, 0.3])
ACTING = np.array([1.0, -2.0, 3.0, 0.05, -0.02, 0.03])
FORCE, TORQUE = np.array([0.5, 0.0, -1.0]), np.array([0.0, 0.01, 0.02])


def body(**changes: Any) -> BodyState:
    model: Any = SimpleNamespace(mass=MASS, gravity=G, inertia_C=INERTIA)
    values = {
        "position": np.zeros(3),
        "velocity": np.zeros(3),
        "R_WC": np.eye(3),
        "angular_velocity": np.zeros(3),
    }
    return BodyState(**{**values, **changes}, model=model)


@pytest.mark.parametrize("latency", [0.0, 0.004, 0.02, 0.0225, 0.07])
def test_the_prediction_is_exact_for_a_constant_acceleration(latency: float) -> None:
    state = DelayState((ACTING,) * DEPTH)
    position, velocity = np.array([1.0, 2.0, 3.0]), np.array([0.1, -0.2, 0.3])
    measured = body(position=position, velocity=velocity)
    now = predict(Delay(latency=latency), state, measured, Wrench(FORCE, np.zeros(3)), DT)
    a = (ACTING[:3] + FORCE) / MASS
    np.testing.assert_allclose(now.velocity, velocity + latency * a, atol=1e-12)
    np.testing.assert_allclose(now.position, position + latency * velocity + 0.5 * latency**2 * a, atol=1e-12)


@pytest.mark.parametrize("latency", [0.004, 0.02, 0.0225])
def test_attitude_is_predicted_about_one_axis_up_to_third_order(latency: float) -> None:
    state = DelayState((np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.06]),) * DEPTH)
    torque, spin = np.array([0.0, 0.0, 0.03]), np.array([0.0, 0.0, 0.4])
    start = rotation_from_rpy(0.1, -0.2, 0.5)
    measured = body(R_WC=start, angular_velocity=spin)
    now = predict(Delay(latency=latency), state, measured, Wrench(np.zeros(3), torque), DT)
    turned = 0.4 * latency + 0.5 * latency**2 * 0.3
    np.testing.assert_allclose(now.angular_velocity, [*spin[:2], spin[2] + latency * 0.3], atol=1e-12)
    wanted = start @ rotation_from_rpy(0.0, 0.0, turned)
    np.testing.assert_allclose(now.R_WC, wanted, atol=turned**3)
    np.testing.assert_allclose(now.R_WC.T @ now.R_WC, np.eye(3), atol=1e-12)


def test_a_force_that_changed_counts_from_when_it_did() -> None:
    # For the last two ticks 4 N, before nothing; 3.5 ticks of latency.
    push, none = np.array([4.0, 0, 0, 0, 0, 0]), np.zeros(6)
    state = DelayState()
    for wrench in (none, push, push):
        state = remember(state, Wrench(wrench[:3], wrench[3:]))
    now = predict(Delay(latency=3.5 * DT), state, body(), Wrench(np.zeros(3), np.zeros(3)), DT)
    assert now.velocity[0] == pytest.approx(2 * DT)
    assert now.position[0] == pytest.approx(0.5 * (2 * DT) ** 2)


@given(st.floats(0.0, DEPTH - 1.0))
def test_the_delayed_wrench_lies_between_two_ticks(ticks: float) -> None:
    state = DelayState(tuple(np.full(6, float(i)) for i in range(DEPTH)))
    found = delayed_wrench(ticks * DT, state, DT)
    np.testing.assert_allclose(np.concatenate(found), ticks, atol=1e-9)


def test_a_measurement_older_than_the_history_is_not_taken_for_free_fall() -> None:
    state = DelayState((ACTING,) * DEPTH)
    found = delayed_wrench(0.15, state, DT)
    np.testing.assert_allclose(np.concatenate(found), ACTING)
    require_history("estimation.delay.latency", 0.07, DT)
    with pytest.raises(ConfigError, match=r"estimation.delay.latency = 0.03 s .* 26 ticks of 0.001 s"):
        require_history("estimation.delay.latency", 0.03, 0.001)
