"""The slope under the pen, learnt from where it has been."""

import numpy as np
import pytest

from skylimb.base.packing import numeric
from skylimb.control.estimation.surface import (
    STEEPEST,
    SurfaceGains,
    SurfaceState,
    follow_surface,
)

DT = 0.005
GAINS = numeric(SurfaceGains(drift=0.3))
NOTHING, STAYS = np.zeros(3), np.zeros(2)


def circle(slope: np.ndarray, noise: float, seconds: float = 14.0) -> SurfaceState:
    rng, state = np.random.default_rng(0), SurfaceState()
    for k in range(round(seconds / DT)):
        angle = 2.0 * np.pi * k * DT / 14.0
        uv = 0.3 * np.array([np.cos(angle), np.sin(angle)])
        place = np.array([slope @ uv, *uv]) + noise * rng.standard_normal(3)
        state = follow_surface(GAINS, state, place, 1.0, float(k == 0), STAYS, NOTHING, DT)
    return state


@pytest.mark.parametrize("slope", [(0.0, 0.0), (0.36, 0.0), (-0.36, 0.2), (0.1, -0.8)])
def test_a_circle_shows_both_slopes(slope: tuple[float, float]) -> None:
    found = circle(np.array(slope), 0.002).estimate
    # A tenth of slope is six degrees.
    np.testing.assert_allclose(found[1:], slope, atol=0.12)


def test_at_rest_nothing_is_learnt() -> None:
    rng, state = np.random.default_rng(1), SurfaceState()
    for k in range(4000):
        place = np.array([0.5, 0.0, 0.0]) + 0.002 * rng.standard_normal(3)
        state = follow_surface(GAINS, state, place, 1.0, float(k == 0), STAYS, NOTHING, DT)
    assert np.abs(state.estimate[1:]).max() < 0.1
    assert abs(state.estimate[0] - 0.5) < 0.003


def test_in_the_air_nothing_changes() -> None:
    before = circle(np.array([0.3, 0.0]), 0.001, 5.0)
    state = before
    for k in range(400):
        state = follow_surface(GAINS, state, np.array([1.0, 0.001 * k, 0.0]), 0.0, 0.0, STAYS, NOTHING, DT)
    np.testing.assert_allclose(state.estimate, before.estimate, atol=1e-9)


def test_the_force_shows_the_slope_across_the_path() -> None:
    """Along u only s_u is seen by the tip; a force that leans across the path tells s_v."""
    state = SurfaceState()
    for k in range(1000):
        place = np.array([0.0, 0.0005 * k, 0.0])
        state = follow_surface(GAINS, state, place, 1.0, float(k == 0), STAYS, np.array([0.0, 1.0, -0.4]), DT)
    assert state.estimate[2] == pytest.approx(-0.4, abs=0.1)


def test_no_slope_is_believed_to_be_steeper_than_the_steepest() -> None:
    found = circle(np.array([9.0, 0.0]), 0.0, 7.0).estimate
    assert np.abs(found[1:]).max() <= STEEPEST


def test_landings_alone_show_the_slope() -> None:
    """Twelve points of a pen that is lifted between them, as dots are drawn."""
    slope, rng = np.array([0.36, -0.1]), np.random.default_rng(2)
    state, last = SurfaceState(), STAYS
    for uv in 0.05 * rng.standard_normal((12, 2)):
        place = np.array([slope @ uv + 0.001 * rng.standard_normal(), *uv])
        state = follow_surface(GAINS, state, place, 1.0, 1.0, (uv - last) * last.any(), NOTHING, DT)
        last = uv
    np.testing.assert_allclose(state.estimate[1:], slope, atol=0.05)
