"""The smoothed state: a model that is right is followed without lag, noise is held back."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from skylimb.base.packing import numeric
from skylimb.base.rotations import rotation_error, rotation_from_rpy, rotation_from_vector
from skylimb.control.estimation.momentum_observer import ObserverGains, ObserverState, observe
from skylimb.control.estimation.records import BodyState
from skylimb.control.estimation.smoothing import Smoothed, Smoothing, smoothed

DT, MASS, INERTIA = 0.005, 4.0, np.diag([0.1, 0.2, 0.3])
BODY_TO_C = rotation_from_rpy(0.1, -0.2, 0.3)
MODEL: Any = SimpleNamespace(mass=MASS, inertia_C=INERTIA, R_root_C=BODY_TO_C)
SLOW = numeric(Smoothing(on=True, position=5.0, velocity=5.0, attitude=5.0, angular_velocity=5.0))
FORCE, MOMENT = np.array([1.0, -2.0, 0.5]), np.array([0.02, 0.05, -0.03])


def known(force: np.ndarray, moment: np.ndarray) -> ObserverState:
    return ObserverState(known_force=force, known_torque=moment, started=1.0)


def test_what_the_model_knows_comes_without_lag() -> None:
    """A body under a constant wrench: poles of 0.2 s leave no error."""
    position, velocity, omega = np.zeros(3), np.array([0.1, 0.0, -0.2]), np.array([0.3, -0.1, 0.2])
    R, kept, observer = rotation_from_rpy(0.2, 0.1, -0.4), Smoothed(), ObserverState()
    for _ in range(200):
        kept, body = smoothed(SLOW, kept, BodyState(position, velocity, R, omega, MODEL), observer, DT)
        observer = known(FORCE, MOMENT)
        position = position + DT * velocity + 0.5 * DT**2 * FORCE / MASS
        velocity = velocity + DT * FORCE / MASS
        spin = DT * np.linalg.solve(INERTIA, MOMENT)
        R = R @ rotation_from_vector(DT * (omega + 0.5 * spin))
        omega = omega + spin
    kept, body = smoothed(SLOW, kept, BodyState(position, velocity, R, omega, MODEL), observer, DT)
    np.testing.assert_allclose(body.position, position, atol=1e-12)
    np.testing.assert_allclose(body.velocity, velocity, atol=1e-12)
    np.testing.assert_allclose(body.angular_velocity, omega, atol=1e-12)
    assert np.abs(rotation_error(body.R_WC, R)).max() < 1e-5
    np.testing.assert_allclose(body.R_WC @ body.R_WC.T, np.eye(3), atol=1e-12)


@pytest.mark.parametrize("entry", ["position", "velocity", "angular_velocity"])
def test_noise_is_low_passed_by_its_own_pole(entry: str) -> None:
    rng, kept, observer, found = np.random.default_rng(2), Smoothed(), ObserverState(), []
    at_rest = BodyState(np.zeros(3), np.zeros(3), np.eye(3), np.zeros(3), MODEL)
    for _ in range(4000):
        seen = at_rest._replace(**{entry: rng.normal(size=3)})
        kept, body = smoothed(SLOW, kept, seen, observer, DT)
        observer = known(np.zeros(3), np.zeros(3))
        found.append(getattr(body, entry))
    share = 1.0 - np.exp(-5.0 * DT)
    assert np.std(found[400:]) == pytest.approx(np.sqrt(share / (2.0 - share)), rel=0.15)


def test_noise_of_the_attitude_too() -> None:
    rng, kept, observer, found = np.random.default_rng(2), Smoothed(), ObserverState(), []
    for _ in range(4000):
        seen = rotation_from_vector(0.01 * rng.normal(size=3)) @ rotation_from_rpy(0.1, 0.2, 0.3)
        kept, body = smoothed(
            SLOW, kept, BodyState(np.zeros(3), np.zeros(3), seen, np.zeros(3), MODEL), observer, DT
        )
        observer = known(np.zeros(3), np.zeros(3))
        found.append(rotation_error(body.R_WC, rotation_from_rpy(0.1, 0.2, 0.3)))
    share = 1.0 - np.exp(-5.0 * DT)
    assert np.std(found[400:]) == pytest.approx(0.01 * np.sqrt(share / (2.0 - share)), rel=0.15)


def test_the_first_measurement_is_believed() -> None:
    seen = BodyState(np.ones(3), np.ones(3), rotation_from_rpy(1.0, 0.5, 2.0), np.ones(3), MODEL)
    _, body = smoothed(SLOW, Smoothed(), seen, ObserverState(), DT)
    for entry in ("position", "velocity", "R_WC", "angular_velocity"):
        np.testing.assert_allclose(getattr(body, entry), getattr(seen, entry), atol=1e-12)


def test_with_the_observer_behind_it_a_force_is_seen_by_a_double_pole() -> None:
    """At b = 4 K: (2 K)^2 / (s + 2 K)^2, of which a step is 1 - (1 + 2 K t) exp(-2 K t)."""
    gain, kept, observer = 10.0, Smoothed(), ObserverState()
    smoothing = numeric(Smoothing(on=True, velocity=4.0 * gain))
    gains, velocity, found = numeric(ObserverGains(force=(gain, gain, gain))), np.zeros(3), []
    for _ in range(120):
        seen = BodyState(np.zeros(3), velocity, np.eye(3), np.zeros(3), MODEL)
        kept, body = smoothed(smoothing, kept, seen, observer, DT)
        observer, wrench = observe(gains, observer, body, DT)
        found.append(wrench.force)
        velocity = velocity + DT * FORCE / MASS
    times = DT * np.arange(120)[:, None]
    wanted = (1.0 - (1.0 + 2.0 * gain * times) * np.exp(-2.0 * gain * times)) * FORCE
    np.testing.assert_allclose(found, wanted, atol=0.1)
