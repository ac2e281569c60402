"""Sets with flat faces against brute force: hulls of corners, and linear programmes in many directions."""

import itertools

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial import ConvexHull

from skylimb.studies.planning.zonotope import Polytope, zonotope, zonotope_volume


class Zonotope:
    """A zonotope with what it was made of."""

    def __init__(self, matrix: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> None:
        self.matrix, self.lower, self.upper = matrix, lower, upper
        self.set = zonotope(matrix, lower, upper)
        self.volume = zonotope_volume(matrix, lower, upper)


def made(d: int, n: int, rank: int | None = None, seed: int = 0) -> Zonotope:
    rng = np.random.default_rng(seed + 10 * d + n)
    Q = rng.normal(size=(d, n))
    if rank is not None:
        Q = rng.normal(size=(d, rank)) @ rng.normal(size=(rank, n))
    lower = rng.uniform(-1.0, 1.0, n)
    return Zonotope(Q, lower, lower + rng.uniform(0.5, 2.0, n))


def corners(z: Zonotope) -> np.ndarray:
    return np.array(list(itertools.product(*zip(z.lower, z.upper, strict=True)))) @ z.matrix.T


def farthest(z: Zonotope, point: np.ndarray, direction: np.ndarray) -> float:
    """The greatest t for which point + t direction is inside, by a linear programme."""
    n = z.matrix.shape[1]
    found = linprog(
        [*np.zeros(n), -1.0],
        A_eq=np.column_stack([z.matrix, -direction]),
        b_eq=point,
        bounds=[*zip(z.lower, z.upper, strict=True), (None, None)],
        method="highs",
    )
    return float(found.x[n]) if found.status == 0 else float("nan")


@pytest.mark.parametrize(("d", "n"), [(2, 4), (3, 4), (3, 8), (4, 6), (6, 6), (6, 8)])
def test_volume_corners_and_faces_are_those_of_the_hull_of_all_corners(d: int, n: int) -> None:
    z = made(d, n)
    hull = ConvexHull(corners(z), qhull_options="Qt Qx" if d > 4 else "Qt")
    assert z.volume == pytest.approx(hull.volume, rel=1e-9)
    assert len(z.set.vertices) == len(hull.vertices)
    theirs = {tuple(row) for row in np.round(hull.equations, 6) + 0.0}
    mine = np.column_stack([z.set.normals @ z.set.axes.T, -z.set.offsets])
    assert {tuple(row) for row in np.round(mine, 6) + 0.0} == theirs
    assert len(mine) == len(theirs)


@pytest.mark.parametrize(("d", "n"), [(3, 4), (3, 8), (6, 8)])
def test_margin_and_reach_are_those_of_linear_programmes(d: int, n: int) -> None:
    z, rng = made(d, n), np.random.default_rng(1)
    inside = z.matrix @ (0.5 * (z.lower + z.upper)) + 0.1 * rng.normal(size=d)
    margin = z.set.margin(inside)
    nearest = z.set.normals[np.argmin(z.set.offsets - z.set.normals @ z.set.axes.T @ inside)]
    assert margin == pytest.approx(farthest(z, inside, z.set.axes @ nearest), abs=1e-9)
    assert margin > 0.0
    around = rng.normal(size=(60, d))
    for direction in around / np.linalg.norm(around, axis=1)[:, None]:
        reach = farthest(z, inside, direction)
        assert z.set.reach(inside, direction) == pytest.approx(reach, abs=1e-9)
        assert reach >= margin - 1e-9
        assert np.isnan(z.set.reach(inside + 2.0 * reach * direction, direction))
        assert z.set.margin(inside + 1.01 * reach * direction) < 0.0


def test_the_margin_is_that_of_brute_force_over_directions() -> None:
    z = made(3, 6)
    point = z.matrix @ (0.5 * (z.lower + z.upper)) + 0.2
    around = np.random.default_rng(0).normal(size=(200_000, 3))
    around /= np.linalg.norm(around, axis=1)[:, None]
    heights = around @ corners(z).T
    assert z.set.margin(point) == pytest.approx((heights.max(axis=1) - around @ point).min(), rel=0.01)


@pytest.mark.parametrize(("d", "n", "rank"), [(6, 4, 4), (6, 8, 4), (3, 5, 1), (3, 6, 2)])
def test_a_flat_one_has_the_faces_and_the_volume_of_the_space_that_it_spans(
    d: int, n: int, rank: int
) -> None:
    z = made(d, n, rank)
    assert z.set.dimension == rank
    flat = corners(z) @ z.set.axes
    volume = np.ptp(flat) if rank == 1 else ConvexHull(flat).volume
    assert z.volume == pytest.approx(volume, rel=1e-9)
    inside, along = z.matrix @ (0.5 * (z.lower + z.upper)), z.matrix @ np.linspace(-1.0, 1.0, n)
    assert z.set.margin(inside) == 0.0
    assert z.set.reach(inside, along) == pytest.approx(farthest(z, inside, along), abs=1e-9)
    beside = np.linalg.svd(z.matrix)[0][:, -1]
    assert z.set.reach(inside, beside) == 0.0
    assert z.set.margin(inside + 0.3 * beside) == pytest.approx(-0.3)
    assert np.isnan(z.set.reach(inside + 0.3 * beside, along))
    assert len(z.set.vertices) == (2 if rank == 1 else len(ConvexHull(flat).vertices))


def test_a_slice_is_what_is_inside_of_the_plane() -> None:
    z, rng = made(6, 8), np.random.default_rng(2)
    origin, axes = z.matrix @ (0.5 * (z.lower + z.upper)), rng.normal(size=(6, 3))
    cut = z.set.section(origin, axes)
    assert cut is not None
    assert cut.dimension == 3
    points = rng.uniform(-1.0, 1.0, (4000, 3)) * np.abs(cut.vertices).max(axis=0)
    inside = np.array([z.set.margin(origin + axes @ y) >= 0.0 for y in points])
    np.testing.assert_array_equal(inside, [cut.margin(y) >= 0.0 for y in points])
    box = 8.0 * np.prod(np.abs(cut.vertices).max(axis=0))
    assert cut.volume == pytest.approx(inside.mean() * box, rel=0.1)
    assert cut.volume == pytest.approx(ConvexHull(cut.vertices).volume, rel=1e-9)
    for direction in rng.normal(size=(20, 3)):
        assert cut.reach(np.zeros(3), direction) == pytest.approx(
            farthest(z, origin, axes @ direction), abs=1e-9
        )
    for corner in cut.vertices:
        assert z.set.margin(origin + axes @ corner) == pytest.approx(0.0, abs=1e-7)


def test_a_slice_of_a_flat_one_extends_only_as_far_as_that_does() -> None:
    z = made(6, 4)
    center = z.matrix @ (0.5 * (z.lower + z.upper))
    within = z.matrix[:, 0] - z.matrix[:, 1]
    cut = z.set.section(center, np.column_stack([within, np.linalg.svd(z.matrix)[0][:, -1]]))
    assert cut is not None
    assert cut.dimension == 1
    assert cut.reach(np.zeros(2), np.array([1.0, 0.0])) == pytest.approx(
        farthest(z, center, within), abs=1e-9
    )
    assert cut.reach(np.zeros(2), np.array([0.0, 1.0])) == 0.0
    assert cut.margin(np.zeros(2)) == 0.0
    assert len(cut.vertices) == 2
    assert z.set.section(center + np.linalg.svd(z.matrix)[0][:, -1], within[:, None]) is None
    point = z.set.section(center, np.linalg.svd(z.matrix)[0][:, -2:])
    assert point is not None
    assert (point.dimension, point.volume, len(point.vertices)) == (0, 0.0, 1)


def test_what_has_no_inside_has_no_corners_and_no_volume() -> None:
    nothing = Polytope(
        np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]]),
        np.array([-1.0, 0, 1, 1]),
        np.zeros(2),
        np.eye(2),
    )
    assert len(nothing.vertices) == 0
    assert nothing.volume == 0.0
    assert nothing.margin(np.zeros(2)) == -1.0
