"""One step of the surface's Kalman filter against the textbook's, with matrices."""

from typing import Any

import numpy as np
import pytest

from skylimb.base.packing import numeric
from skylimb.control.estimation.surface import (
    REST_SPEED,
    SMOOTHING,
    STEEPEST,
    SurfaceGains,
    SurfaceState,
    follow_surface,
)

DT = 0.005
GAINS: Any = numeric(SurfaceGains(drift=0.4, height_noise=0.002, cross_noise=2.0))
COVARIANCE = np.array([[2e-4, 1e-4, -5e-5], [1e-4, 0.05, 0.01], [-5e-5, 0.01, 0.08]])
BEFORE = SurfaceState(np.array([1.1, 0.2, -0.3]), COVARIANCE, np.array([0.4, 0.5]))
NOTHING = np.zeros(3)
STAYS = np.zeros(2)
DIAGONAL = np.diag([0.0, 1.0, 1.0])


def scalar_update(x: np.ndarray, P: np.ndarray, h: np.ndarray, z: float, noise: float, weight: float) -> Any:
    gain = weight * P @ h / (h @ P @ h + noise)
    return x + gain * (z - h @ x), P - np.outer(gain, P @ h)


def textbook(place: np.ndarray, touching: float, fresh: float, across: np.ndarray) -> SurfaceState:
    share = 1.0 - np.exp(-DT / SMOOTHING)
    calm = place[1:] if fresh else BEFORE.place + share * (place[1:] - BEFORE.place)
    moved = np.zeros(2) if fresh else calm - BEFORE.place
    way = touching * max(np.hypot(moved[0], moved[1]) - REST_SPEED * DT, 0.0)
    A = np.eye(3)
    A[0, 1:] = touching * moved
    x, P = A @ BEFORE.estimate, A @ BEFORE.covariance @ A.T + way * 0.4 * DIAGONAL
    if fresh:
        x[0] = place[0]
    trust = way / (way + REST_SPEED * DT)
    weight = touching * (1.0 if fresh else trust)
    x, P = scalar_update(x, P, np.array([1.0, 0.0, 0.0]), place[0], 0.002**2, weight)
    known = (across[0] ** 2 + across[1] ** 2) * touching * trust
    x, P = scalar_update(x, P, np.array([0.0, *across[:2]]), across[2], 2.0**2, known)
    return SurfaceState(x, P, calm)


@pytest.mark.parametrize(
    ("place", "touching", "fresh", "across"),
    [
        ((1.12, 0.43, 0.46), 1.0, 0.0, NOTHING),
        ((1.12, 0.43, 0.46), 1.0, 0.0, np.array([0.6, 0.8, 0.5])),
        ((1.12, 0.41, 0.55), 1.0, 0.0, np.array([-0.3, 0.4, -0.2])),
        ((1.12, 0.43, 0.46), 1.0, 1.0, NOTHING),
        ((1.12, 0.43, 0.46), 0.0, 0.0, np.array([0.6, 0.8, 0.5])),
        ((1.12, 0.4001, 0.5001), 1.0, 0.0, np.array([0.6, 0.8, 0.5])),
    ],
)
def test_one_step_is_the_textbooks(
    place: tuple[float, ...], touching: float, fresh: float, across: np.ndarray
) -> None:
    found = follow_surface(GAINS, BEFORE, np.array(place), touching, fresh, STAYS, across, DT)
    wanted = textbook(np.array(place), touching, fresh, across)
    np.testing.assert_allclose(found.estimate, wanted.estimate, atol=1e-9)
    np.testing.assert_allclose(found.covariance, wanted.covariance, atol=1e-9)
    np.testing.assert_allclose(found.place, wanted.place, atol=1e-12)


HOP = np.array([0.03, -0.02])


def landed(height: float) -> SurfaceState:
    """A pen that lands again, 36 mm from where it touched."""
    return follow_surface(GAINS, BEFORE, np.array([height, 0.43, 0.48]), 1.0, 1.0, HOP, NOTHING, DT)


def test_a_landing_shows_how_far_the_surface_has_risen() -> None:
    away = float(np.hypot(*HOP))
    A = np.eye(3)
    A[0, 1:] = HOP
    P = A @ COVARIANCE @ A.T + 0.4 * (away * DIAGONAL + away**3 * np.diag([1.0, 0.0, 0.0]))
    x = A @ BEFORE.estimate
    height = x[0] + 0.004
    x, P = scalar_update(x, P, np.array([1.0, 0.0, 0.0]), height, 0.002**2, 1.0)
    found = landed(height)
    np.testing.assert_allclose(found.estimate, x, atol=1e-9)
    np.testing.assert_allclose(found.covariance, P, atol=1e-9)
    np.testing.assert_allclose(found.place, [0.43, 0.48], atol=1e-12)


def test_a_landing_far_from_where_it_was_expected_is_a_step_and_no_slope() -> None:
    expected = 1.1 + 0.2 * HOP[0] - 0.3 * HOP[1]
    for step in (0.1, -0.1):
        found = landed(expected + step)
        np.testing.assert_allclose(found.estimate, [expected + step, 0.2, -0.3], atol=1e-9)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_no_slope_is_believed_to_be_steeper_than_the_steepest(sign: float) -> None:
    steep = BEFORE._replace(estimate=np.array([1.1, sign * 9.0, -sign * 9.0]))
    found = follow_surface(GAINS, steep, np.array([1.1, 0.4, 0.5]), 0.0, 0.0, STAYS, NOTHING, DT)
    np.testing.assert_allclose(found.estimate[1:], [sign * STEEPEST, -sign * STEEPEST])
    assert STEEPEST == 2.0


def test_a_pen_that_creeps_learns_nothing() -> None:
    """Slower than its noise may feign, 3 cm/s behind a low pass of 0.1 s."""
    assert (SMOOTHING, REST_SPEED) == (0.1, 0.03)
    share = 1.0 - np.exp(-DT / SMOOTHING)
    for way, learns in ((0.9 * REST_SPEED * DT / share, False), (1.5 * REST_SPEED * DT / share, True)):
        place = np.array([1.2, 0.4 + way, 0.5])
        found = follow_surface(GAINS, BEFORE, place, 1.0, 0.0, STAYS, NOTHING, DT)
        carried = 1.1 + 0.2 * share * way
        assert bool(abs(found.estimate[0] - carried) > 1e-6) is learns


def test_before_the_first_touch_a_slope_of_17_degrees_is_likely() -> None:
    state = SurfaceState()
    assert not state.estimate.any()
    assert not state.place.any()
    np.testing.assert_allclose(state.covariance, np.diag([0.05**2, 0.3**2, 0.3**2]))


def test_what_is_assumed_of_pen_and_surface() -> None:
    assert SurfaceGains() == SurfaceGains(0.5, 0.003, 3.0)
