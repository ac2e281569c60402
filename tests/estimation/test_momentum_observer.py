"""The observer against its own differential equation, eq:external wrench estimation low-pass."""

import numpy as np
import pytest

from skylimb.estimation.momentum_observer import (
    ObserverGains,
    initial_observer_state,
    known_wrench,
    observe,
)
from skylimb.estimation.records import BodyState, Wrench
from skylimb.packing import numeric
from skylimb.robots import load_robot

DT, WRENCH = 0.005, np.array([1.0, -2.0, 0.5])


def estimates(
    gains: ObserverGains, ticks: int, force: np.ndarray, torque: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """A rigid body under hover thrust and a constant external wrench from the first tick on, exactly."""
    robot = load_robot("hydrus_xi_quad")
    model = robot.at([np.pi / 3, np.pi / 3, -np.pi / 6], [3.0, 0.1, 3.0, 0.1])
    state, record = initial_observer_state(), numeric(gains)
    velocity, momentum = np.zeros(3), np.zeros(3)
    found = []
    for _ in range(ticks):
        omega = np.linalg.solve(model.inertia_C, momentum)
        body = BodyState(np.zeros(3), velocity, np.eye(3), omega, model)
        state, wrench = observe(record, state, body, DT)
        found.append(np.concatenate([wrench.force, wrench.torque]))
        # The rotors carry the weight and cancel the gyroscopic torque, so that momentum grows by the external
        # wrench alone.
        gyroscopic = np.cross(omega, model.inertia_C @ omega)
        known = known_wrench(body, Wrench(np.array([0.0, 0.0, model.mass * 9.80665]), gyroscopic))
        state = state._replace(known_force=known.force, known_torque=known.torque)
        velocity = velocity + force / model.mass * DT
        momentum = momentum + torque * DT
    table = np.array(found)
    return table[:, :3], table[:, 3:]


@pytest.mark.parametrize("gain", [1.0, 3.0, 10.0])
def test_a_step_is_answered_like_a_first_order_low_pass(gain: float) -> None:
    gains = ObserverGains((gain, gain, gain), (gain, gain, gain))
    force, torque = estimates(gains, 400, WRENCH, 0.1 * WRENCH)
    expected = 1.0 - np.exp(-gain * DT * np.arange(400))
    np.testing.assert_allclose(force, expected[:, None] * WRENCH, atol=1e-9)
    np.testing.assert_allclose(torque, expected[:, None] * 0.1 * WRENCH, atol=1e-9)


def test_without_a_wrench_the_estimate_stays_zero() -> None:
    force, torque = estimates(ObserverGains(), 50, np.zeros(3), np.zeros(3))
    assert np.abs(force).max() < 1e-12
    assert np.abs(torque).max() < 1e-12
