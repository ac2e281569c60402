"""What is learnt of the force across the contact axis."""

from typing import Any

import numpy as np
import pytest

from skylimb.base.packing import numeric
from skylimb.control.estimation.friction import (
    MOST,
    SURE,
    Climbed,
    FrictionGains,
    FrictionState,
    direction,
    expected_across,
    follow_friction,
    initial_friction_state,
)
from skylimb.symbolic import low_pass

DT = 0.005
GAINS: Any = numeric(FrictionGains(rate=0.5, first=0.2, lag=8.0, speed=0.01))
LEAN, FRICTION = np.array([0.3, -0.1]), 0.45
UNKNOWN = Climbed(np.zeros(2), np.full(2, 1e9), 0.0)


def slide(seconds: float, share: float = 1.0, speed: float = 0.05) -> FrictionState:
    """A circle of 4 s, seen through an observer of the assumed bandwidth."""
    state, seen = numeric(initial_friction_state(GAINS)), np.zeros(2)
    for t in np.arange(0.0, seconds, DT):
        path = speed * np.array([np.cos(1.57 * t), np.sin(1.57 * t)])
        true = share * (LEAN - FRICTION * path / speed)
        seen = np.array([low_pass(seen[i], true[i], 8.0, DT) for i in (0, 1)])
        state = follow_friction(GAINS, state, seen, share, path, UNKNOWN, DT)
    return state


@pytest.mark.parametrize("share", [1.0, 0.6])
def test_slope_and_friction_are_told_apart(share: float) -> None:
    state = slide(20.0, share)
    np.testing.assert_allclose(state.lean, LEAN, atol=0.01)
    assert state.friction == pytest.approx(FRICTION, abs=0.01)


def test_nothing_is_learnt_at_rest_or_without_a_press() -> None:
    for state in (slide(5.0, speed=1e-6), slide(5.0, share=0.2)):
        np.testing.assert_allclose(state.lean, [0.0, 0.0], atol=1e-9)
        assert state.friction == 0.2


def test_what_is_expected() -> None:
    state = FrictionState(LEAN, FRICTION, np.zeros(2))
    np.testing.assert_allclose(expected_across(state, 0.5, np.zeros(2)), 0.5 * LEAN)
    ahead = direction(GAINS, np.array([0.0, -0.03]))
    np.testing.assert_allclose(ahead, [0.0, -1.0], atol=1e-6)
    np.testing.assert_allclose(expected_across(state, 1.0, ahead), [0.3, -0.1 + FRICTION], atol=1e-6)
    np.testing.assert_allclose(direction(GAINS, np.array([0.004, 0.0])), [0.4, 0.0], atol=1e-6)


def test_a_wrong_force_teaches_no_more_than_a_surface_can_do() -> None:
    state = numeric(initial_friction_state(GAINS))
    for _ in range(20000):
        along = np.array([0.05, 0.0])
        state = follow_friction(GAINS, state, np.array([-9.0, 9.0]), 1.0, along, UNKNOWN, DT)
    assert np.abs(state.lean).max() <= MOST
    assert 0.0 <= state.friction <= MOST


@pytest.mark.parametrize(("variance", "share"), [(0.0, 1.0), (SURE**2, 0.5), (1e9, 0.0)])
def test_a_slope_that_was_climbed_is_known_the_more_the_surer_it_is(variance: float, share: float) -> None:
    """A tick at rest, where the force says nothing: friction holds the pen."""
    state = numeric(initial_friction_state(GAINS))
    climbed = Climbed(np.array([0.36, -0.2]), np.full(2, variance), 0.05)
    seen, rests = np.array([-5.0, 5.0]), np.zeros(2)
    state = follow_friction(GAINS, state, seen, 1.0, rests, climbed, DT)
    np.testing.assert_allclose(state.lean, GAINS.slope_rate * DT * share * climbed.lean, atol=1e-9)
    assert state.friction == 0.2


def test_a_pen_in_the_air_forgets_no_slope() -> None:
    state = FrictionState(LEAN, FRICTION, np.zeros(2))
    flat = Climbed(np.zeros(2), np.zeros(2), 0.0)
    found = follow_friction(GAINS, state, np.zeros(2), 0.0, np.array([0.05, 0.0]), flat, DT)
    np.testing.assert_array_equal(found.lean, LEAN)


@pytest.mark.parametrize(("speed", "share"), [(0.0, 1.0), (0.05, 1.0), (0.075, 0.5), (0.1, 0.0), (0.5, 0.0)])
def test_along_a_fast_path_the_force_alone_tells(speed: float, share: float) -> None:
    """A board that sways looks like a slope, to a pen that crosses it fast."""
    state, rests = numeric(initial_friction_state(GAINS)), np.zeros(2)
    climbed = Climbed(np.array([0.36, -0.2]), np.zeros(2), speed)
    state = follow_friction(GAINS, state, rests, 1.0, rests, climbed, DT)
    np.testing.assert_allclose(state.lean, GAINS.slope_rate * DT * share * climbed.lean, atol=1e-9)
