"""Splines and Gaussians in NumPy give SciPy's numbers to the bit."""

import numpy as np
import pytest
from scipy import ndimage

from skylimb.simulation.surfaces import bspline


@pytest.mark.parametrize("shape", [(4, 5), (12, 12), (64, 48)])
def test_a_spline_is_scipys(rng, shape):
    samples = rng.normal(size=shape)
    coefficients = bspline.coefficients(samples)
    np.testing.assert_array_equal(coefficients, ndimage.spline_filter(samples, order=3, mode="mirror"))
    places = [np.linspace(0, n - 1, 3 * n + 1) for n in shape]
    grid = np.meshgrid(*places, indexing="ij")
    expected = ndimage.map_coordinates(samples, grid, order=3, mode="mirror")
    np.testing.assert_array_equal(bspline.at_grid(coefficients, *places), expected)


def test_a_gaussian_is_scipys(rng):
    values, deviations = rng.normal(size=(30, 40)), np.array([1.3, 2.7])
    expected = ndimage.gaussian_filter(values, deviations, mode="nearest")
    np.testing.assert_array_equal(bspline.smoothed(values, deviations), expected)
