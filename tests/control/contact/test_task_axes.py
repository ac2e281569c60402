"""What is felt in the axes of the task, against the geometry of an inclined plane."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skylimb.control.contact.task_axes import in_task, normal_force_on, seen_across
from skylimb.control.estimation.records import Wrench

AXES = (np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]))
slopes = st.floats(-1.0, 1.0)


def felt(slope: np.ndarray, pressed: float, friction: float, way: np.ndarray) -> Wrench:
    """What a pen feels that presses on the plane x = slope . (y, z), and slides along it."""
    normal = np.array([-1.0, *slope]) / np.sqrt(1.0 + slope @ slope)  # out of the surface
    along = np.array([slope @ way, *way])
    force = pressed * normal - friction * pressed * along / np.linalg.norm(along)
    return Wrench(force, np.zeros(3))


@given(slopes, slopes, st.floats(0.1, 10.0), st.floats(0.0, 1.0), st.floats(-3.0, 3.0))
def test_friction_drops_out_of_the_normal_force(
    u: float, v: float, pressed: float, friction: float, angle: float
) -> None:
    slope, way = np.array([u, v]), np.array([np.cos(angle), np.sin(angle)])
    assert normal_force_on(felt(slope, pressed, friction, way), slope, AXES) == pytest.approx(pressed)


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.0])
def test_across_the_path_the_slope_is_seen_without_friction(angle: float) -> None:
    way = 0.05 * np.array([np.cos(angle), np.sin(angle)])
    across = np.array([-way[1], way[0]]) / np.linalg.norm(way)
    slope = 0.2 * across  # level along the path: friction has no part across it
    seen = np.asarray(seen_across(felt(slope, 1.0, 0.5, way), way, 0.05, AXES), dtype=float)
    np.testing.assert_allclose(seen[:2], across, atol=1e-6)
    pressed = felt(slope, 1.0, 0.5, way).force
    assert seen[2] == pytest.approx(pressed[1:] @ across / pressed[0])
    assert abs(seen[2]) == pytest.approx(0.2)


def test_at_rest_nothing_is_seen_across() -> None:
    seen = np.asarray(
        seen_across(felt(np.array([0.1, 0.0]), 1.0, 0.0, np.array([1.0, 0.0])), np.zeros(2), 0.0, AXES)
    )
    np.testing.assert_array_equal(seen[:2], np.zeros(2))


def test_a_vector_is_turned_into_the_axes_of_the_task() -> None:
    axes = (np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    np.testing.assert_array_equal(in_task(np.array([1.0, 2.0, 3.0]), axes), [3.0, 1.0, 2.0])
