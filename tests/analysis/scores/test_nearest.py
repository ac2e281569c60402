"""The search for nearest points against looking at every pair."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skylimb.analysis.scores.nearest import distances, nearest


def walk(rng: np.random.Generator, count: int, step: float) -> np.ndarray:
    return np.cumsum(rng.normal(scale=step, size=(count, 2)), axis=0)


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**31),
    n=st.integers(1, 200),
    k=st.integers(1, 200),
    step=st.sampled_from([1e-6, 1.0]),
)
def test_every_point_finds_its_nearest(seed: int, n: int, k: int, step: float) -> None:
    rng = np.random.default_rng(seed)
    points, among = walk(rng, n, step), walk(rng, k, 1.0)
    apart = np.linalg.norm(points[:, None] - among, axis=2)
    np.testing.assert_array_equal(nearest(points, among), apart.argmin(axis=1))
    np.testing.assert_allclose(distances(points, among), apart.min(axis=1), rtol=1e-14)


def test_of_equals_the_first() -> None:
    among = np.tile([[1.0, 0.0], [0.0, 1.0]], (40, 1))
    assert nearest(np.zeros((20, 2)), among).tolist() == [0] * 20


def test_lines_far_apart_and_scattered_points() -> None:
    rng = np.random.default_rng(3)
    points, among = rng.uniform(-1.0, 1.0, (500, 2)), rng.uniform(5.0, 6.0, (3000, 2))
    apart = np.linalg.norm(points[:, None] - among, axis=2)
    np.testing.assert_array_equal(nearest(points, among), apart.argmin(axis=1))


@pytest.mark.parametrize("count", [1, 16, 17])
def test_no_points_and_whole_blocks(count: int) -> None:
    assert nearest(np.zeros((0, 2)), np.zeros((count, 2))).shape == (0,)
    assert nearest(np.ones((count, 2)), np.zeros((count, 2))).tolist() == [0] * count
