"""A pen under the body: what a tilt moves it is made up for slowly, so that its own zero does no harm."""

from typing import Any

import numpy as np
import pytest

from skylimb.control.translation.hanging import FIRMER, SLOWLY, slow_arm

DT = 0.005


class Body:
    """A body that is tilted by `rpy`'s pitch, rad."""

    def __init__(self, pitch: float) -> None:
        c, s = np.cos(pitch), np.sin(pitch)
        self.R_WC = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


class Known:
    """An estimate of a body with an arm in its own axes, m."""

    def __init__(self, arm: list[float], pitch: float) -> None:
        self.body = Body(pitch)
        self.arm = self.body.R_WC @ np.array(arm)


@pytest.mark.parametrize("arm", [[0.6, 0.0, 0.0], [0.5, 0.1, -0.1], [0.0, 0.0, 0.4]])
def test_a_pen_ahead_of_the_body_or_above_it_is_followed_as_it_is(arm: list[float]) -> None:
    at: Any = Known(arm, 0.1)
    found = slow_arm(at, 1.0, np.zeros(3), DT)
    np.testing.assert_array_equal(found.arm, at.arm)
    np.testing.assert_array_equal(found.swings, at.arm)
    assert found.firmness == 1.0


def test_a_hanging_pen_is_followed_where_the_level_robot_has_it_and_slowly_where_it_is() -> None:
    at: Any = Known([0.1, 0.0, -0.5], 0.1)
    found = slow_arm(at, 1.0, np.zeros(3), 1e-9)
    # The hanging part is upright as in a level robot; what is ahead turns with the body.
    np.testing.assert_allclose(found.arm[:2], [0.1 * np.cos(0.1), 0.0], atol=2e-3)
    assert found.firmness > 1.3
    for _ in range(int(10.0 / SLOWLY / DT)):
        found = slow_arm(at, 1.0, found.slow, DT)
    np.testing.assert_allclose(found.arm, at.arm, atol=1e-4)


def test_the_swing_of_what_hangs_is_not_counted() -> None:
    """Only what is ahead of the body swings; what hangs goes the wrong way first."""
    at: Any = Known([0.1, 0.0, -0.5], 0.1)
    ahead = at.body.R_WC @ np.array([0.1, 0.0, 0.0])
    np.testing.assert_allclose(slow_arm(at, 1.0, np.zeros(3), DT).swings, ahead, atol=1e-12)
    np.testing.assert_array_equal(slow_arm(at, 0.0, np.zeros(3), DT).swings, at.arm)


def test_a_robot_that_need_not_tilt_follows_its_pen_at_once() -> None:
    at: Any = Known([0.0, 0.0, -0.5], 0.2)
    found = slow_arm(at, 0.0, np.zeros(3), DT)
    np.testing.assert_array_equal(found.arm, at.arm)
    assert found.firmness == 1.0


@pytest.mark.parametrize(("share", "calm"), [(0.0, False), (1.0, True)])
def test_of_the_linear_loop_the_spring_at_the_pen_sways_and_that_at_the_level_pen_does_not(
    share: float, calm: bool
) -> None:
    """Poles of x'' = g theta: attitude loop of 14 rad/s, age of 40 ms, h = 0.5 m, K = 15 1/s^2."""
    g, h, K, w, age = 9.81, 0.5, 15.0, 14.0, 0.04
    D = 2.0 * 0.8 * np.sqrt(K) * (1.0 + FIRMER * share)
    # States: x, v, theta, omega, what is commanded late, slow way; theta moves the pen by -h theta.
    spring = np.array([K, D, -K * h * (1.0 - share), 0.0, 0.0, -K * share])
    A = np.zeros((6, 6))
    A[0, 1], A[1, 2], A[2, 3] = 1.0, g, 1.0
    A[3, 2], A[3, 3], A[3, 4] = -(w**2), -2.0 * w, w**2
    A[4] = -spring / g / age
    A[4, 4] -= 1.0 / age
    A[5, 2], A[5, 5] = SLOWLY * h, -SLOWLY
    assert (np.linalg.eigvals(A).real.max() < -0.3) == calm
