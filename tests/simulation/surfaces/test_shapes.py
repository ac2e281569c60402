"""Closest points and what is drawn of simple shapes, against their own formulas."""

import numpy as np
import pytest

from skylimb.simulation.surfaces.ball import Sphere
from skylimb.simulation.surfaces.box import closest_on_box

HALF = np.array([0.3, 0.2, 0.1])


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_nearest_face_of_a_point_in_a_box_counts(axis: int, side: float) -> None:
    point = np.zeros(3)
    point[axis] = side * (HALF[axis] - 0.02)
    foot, normal, distance = closest_on_box(point, HALF)
    np.testing.assert_array_equal(normal, side * np.eye(3)[axis])
    np.testing.assert_allclose(foot, point + 0.02 * normal)
    assert distance == pytest.approx(-0.02)
    outside = point + 0.05 * normal
    foot, normal, distance = closest_on_box(outside, HALF)
    np.testing.assert_allclose(normal, side * np.eye(3)[axis], atol=1e-12)
    np.testing.assert_allclose(foot, outside - 0.03 * normal)
    assert distance == pytest.approx(0.03)


@pytest.mark.parametrize(
    ("size", "radius", "half"),
    [((0.6, 2.0), 1.0, 0.3), ((2.0, 0.6), 1.0, 0.3), ((2.0, 2.0), 0.5, 0.35)],
)
def test_a_sphere_is_drawn_within_its_size_and_its_front(
    size: tuple[float, float], radius: float, half: float
) -> None:
    sphere = Sphere(size=size, radius=radius)
    for drawn in (sphere.drawn_u(), sphere.drawn_v()):
        assert (drawn[0], drawn[-1]) == pytest.approx((-half, half))
