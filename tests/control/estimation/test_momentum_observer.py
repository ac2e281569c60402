"""The observer against its own differential equation, eq:external wrench estimation low-pass."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from skylimb.base.packing import numeric
from skylimb.control.estimation.momentum_observer import (
    ObserverGains,
    ObserverState,
    known_wrench,
    observe,
)
from skylimb.control.estimation.records import BodyState, Wrench
from skylimb.robots.description import GRAVITY

G = np.array([0.0, 0.0, GRAVITY])

DT, WRENCH = 0.005, np.array([1.0, -2.0, 0.5])
MASS, INERTIA = 4.0, np.array([[0.11, 0.01, 0.02], [0.01, 0.21, -0.03], [0.02, -0.03, 0.3]])
FORCE_GAINS, TORQUE_GAINS = np.array([1.0, 3.0, 10.0]), np.array([2.0, 5.0, 0.5])
THRUST, TURN = np.array([0.5, 1.0, 42.0]), np.array([0.02, 0.01, -0.03])
MODEL: Any = SimpleNamespace(mass=MASS, gravity=G, inertia_C=INERTIA)


def body(velocity: np.ndarray, momentum: np.ndarray) -> BodyState:
    return BodyState(np.zeros(3), velocity, np.eye(3), np.linalg.solve(INERTIA, momentum), MODEL)


def estimates(
    ticks: int, force: np.ndarray, torque: np.ndarray, thrust: np.ndarray, turn: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """A rigid body under rotors that do `thrust` and `turn`, and a constant external wrench, exactly."""
    gains = numeric(ObserverGains(tuple(FORCE_GAINS), tuple(TORQUE_GAINS)))
    state = ObserverState()
    velocity, momentum = np.array([0.3, -0.1, 0.2]), np.array([0.1, 0.0, 0.05])
    found = []
    for _ in range(ticks):
        now = body(velocity, momentum)
        state, wrench = observe(gains, state, now, DT)
        found.append(np.concatenate([wrench.force, wrench.torque]))
        gyroscopic = np.cross(now.angular_velocity, momentum)
        known = known_wrench(now, Wrench(thrust, turn + gyroscopic))
        state = state._replace(known_force=known.force, known_torque=known.torque)
        velocity = velocity + (thrust + force - MASS * np.array([0.0, 0.0, 9.80665])) / MASS * DT
        momentum = momentum + (turn + torque) * DT
    table = np.array(found)
    return table[:, :3], table[:, 3:]


def test_a_step_is_answered_like_a_first_order_low_pass() -> None:
    """On every axis at its own gain; what the rotors do leaves no trace."""
    force, torque = estimates(400, WRENCH, 0.1 * WRENCH, THRUST, TURN)
    times = DT * np.arange(400)[:, None]
    np.testing.assert_allclose(force, (1.0 - np.exp(-FORCE_GAINS * times)) * WRENCH, atol=1e-9)
    np.testing.assert_allclose(torque, (1.0 - np.exp(-TORQUE_GAINS * times)) * 0.1 * WRENCH, atol=1e-9)


def test_without_a_wrench_the_estimate_stays_zero() -> None:
    force, torque = estimates(50, np.zeros(3), np.zeros(3), THRUST, TURN)
    assert np.abs(force).max() < 1e-12
    assert np.abs(torque).max() < 1e-12


def test_what_is_known_to_act_is_thrust_less_weight_and_less_the_gyroscopic_torque() -> None:
    now = body(np.zeros(3), np.array([0.3, -0.2, 0.4]))
    known = known_wrench(now, Wrench(np.array([1.0, 2.0, 41.0]), np.array([0.1, 0.2, 0.3])))
    np.testing.assert_allclose(known.force, [1.0, 2.0, 41.0 - MASS * 9.80665])
    gyroscopic = np.cross(now.angular_velocity, INERTIA @ now.angular_velocity)
    np.testing.assert_allclose(known.torque, np.array([0.1, 0.2, 0.3]) - gyroscopic)
    assert np.abs(gyroscopic).max() > 0.01


def test_one_tick_in_numbers() -> None:
    gains = numeric(ObserverGains(tuple(FORCE_GAINS), tuple(TORQUE_GAINS)))
    before = ObserverState()._replace(
        force=np.array([0.5, 0.6, 0.7]),
        torque=np.array([0.05, 0.06, 0.07]),
        linear_momentum=np.array([1.0, 1.1, 1.2]),
        angular_momentum=np.array([0.01, 0.02, 0.03]),
        known_force=np.array([0.1, 0.2, 0.3]),
        known_torque=np.array([0.3, 0.2, 0.1]),
        started=1.0,
    )
    velocity, momentum = np.array([0.26, 0.27, 0.31]), np.array([0.012, 0.019, 0.033])
    state, wrench = observe(gains, before, body(velocity, momentum), DT)
    seen = (MASS * velocity - before.linear_momentum) / DT - before.known_force
    decay = np.exp(-FORCE_GAINS * DT)
    np.testing.assert_allclose(wrench.force, decay * before.force + (1.0 - decay) * seen)
    seen = (momentum - before.angular_momentum) / DT - before.known_torque
    decay = np.exp(-TORQUE_GAINS * DT)
    np.testing.assert_allclose(wrench.torque, decay * before.torque + (1.0 - decay) * seen)
    np.testing.assert_allclose(state.linear_momentum, MASS * velocity)
    np.testing.assert_allclose(state.angular_momentum, momentum)
    np.testing.assert_array_equal(state.known_force, before.known_force)
    assert state.started == 1.0


def test_the_first_tick_has_no_past() -> None:
    state = ObserverState()
    assert state.started == 0.0
    assert not any(np.any(part) for part in state[:6])
    state, wrench = observe(numeric(ObserverGains()), state, body(np.ones(3), np.ones(3)), DT)
    assert not np.any(wrench.force)
    assert not np.any(wrench.torque)


def test_the_gains_are_the_papers_unless_a_preset_says_otherwise() -> None:
    assert ObserverGains() == ObserverGains((3.0, 3.0, 3.0), (1.0, 1.0, 1.0))
