"""The quintic that paths are timed with."""

import numpy as np
import pytest

from skylimb.control.planning.smooth_step import STEEPEST, quintic, smooth_step

S = np.linspace(0.0, 1.0, 2001)


def test_it_rises_from_zero_to_one_without_slope_or_curvature_at_its_ends() -> None:
    value, slope, curvature = quintic(S)
    assert (value[0], value[-1]) == (0.0, pytest.approx(1.0))
    assert slope[[0, -1]].tolist() == curvature[[0, -1]].tolist() == [0.0, 0.0]
    np.testing.assert_allclose(np.gradient(value, S, edge_order=2), slope, atol=2e-5)
    np.testing.assert_allclose(np.gradient(slope, S, edge_order=2), curvature, atol=1e-4)
    assert slope.max() == pytest.approx(STEEPEST)
    np.testing.assert_allclose(value + value[::-1], 1.0)


def test_the_step_is_its_rate_with_integral_and_derivative() -> None:
    t = np.linspace(-0.5, 3.0, 35001)
    integral, rate, slope = smooth_step(t, 2.0)
    assert (rate[0], rate[-1]) == (0.0, pytest.approx(1.0))
    np.testing.assert_allclose(np.gradient(integral, t), rate, atol=1e-4)
    np.testing.assert_allclose(np.gradient(rate, t), slope, atol=1e-3)
    assert integral[-1] == pytest.approx(3.0 - 1.0)
