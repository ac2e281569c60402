"""Joints go from knot to knot of a path, and rest at each."""

import numpy as np

from skylimb.control.planning.posture_path import PosturePath


def test_it_is_half_way_at_half_the_time_between_two_knots() -> None:
    path = PosturePath(np.array([0.0, 2.0, 3.0, 7.0]), np.array([[0.0], [1.0], [-1.0], [3.0]]))
    found = path.sample(np.array([-1.0, 0.0, 1.0, 2.0, 2.5, 3.0, 5.0, 7.0, 9.0]))
    np.testing.assert_allclose(found[:, 0], [0.0, 0.0, 0.5, 1.0, 0.0, -1.0, 1.0, 3.0, 3.0], atol=1e-12)


def test_one_knot_is_held() -> None:
    path = PosturePath(np.zeros(1), np.array([[0.3, 0.4]]))
    np.testing.assert_array_equal(path.sample(np.array([0.0, 1.0])), [[0.3, 0.4], [0.3, 0.4]])
