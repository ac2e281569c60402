"""Convex sets with flat faces: all that rotors between their limits can give, and slices of it.

Thrusts lambda with lower <= lambda <= upper give the wrenches Q lambda, a zonotope: the sum of one segment
for each rotor. A facet of it is spanned by the segments of as many rotors as make its dimension; the others
push fully or least, whichever is farther out. So facets, distances and volume follow in closed form, from
all choices of rotors, without a search (C. Ewald, Combinatorial Convexity; G. C. Shephard, 1974).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skylimb.base.errors import extra_module

_RANK = 1e-9
"""Singular values below this share of the greatest count as zero."""


@dataclass(frozen=True)
class Polytope:
    """All points origin + axes y with normals y <= offsets; flat where it has fewer axes than space has.

    Attributes:
        normals: outward unit normals of the facets, (m, dimension).
        offsets: distance of each facet from `origin` along its normal, (m,).
        origin: a point of the plane in which it lies, (d,).
        axes: orthonormal directions of that plane, (d, dimension).
    """

    normals: np.ndarray
    offsets: np.ndarray
    origin: np.ndarray
    axes: np.ndarray

    @property
    def dimension(self) -> int:
        """In how many directions it extends."""
        return self.axes.shape[1]

    def margin(self, point: np.ndarray) -> float:
        """Distance of a point (d,) to the nearest one outside; 0 where it is flat, negative outside."""
        along, beside = self._split(point - self.origin)
        if beside > 1e-9 * (1.0 + np.linalg.norm(point)):
            return -beside
        least = float(np.min(self.offsets - self.normals @ along, initial=np.inf))
        return least if self.dimension == len(self.origin) else min(least, 0.0)

    def reach(self, point: np.ndarray, direction: np.ndarray) -> float:
        """The greatest t for which point + t direction is inside; NaN from a point outside of it."""
        along, beside = self._split(point - self.origin)
        room = self.offsets - self.normals @ along
        slack = 1e-9 * (1.0 + np.abs(self.offsets))
        if beside > 1e-7 * (1.0 + np.linalg.norm(point)) or np.any(room < -slack):
            return float("nan")
        way, aside = self._split(direction)
        if aside > 1e-7 * np.linalg.norm(direction):
            return 0.0
        speed = self.normals @ way
        ahead = speed > 1e-12 * np.linalg.norm(direction)
        return float(np.min(np.maximum(room[ahead], 0.0) / speed[ahead], initial=np.inf))

    def section(self, origin: np.ndarray, axes: np.ndarray) -> Polytope | None:
        """Its slice in the coordinates y of origin + axes y, origin (d,), axes (d, k); None if it misses."""
        beside = np.eye(len(origin)) - self.axes @ self.axes.T
        left, sizes, right = np.linalg.svd(beside @ axes)
        across = int(np.sum(sizes > 1e-9 * (1.0 + np.linalg.norm(axes))))
        missing = beside @ (self.origin - origin)
        start = right[:across].T @ ((left[:, :across].T @ missing) / sizes[:across])
        if np.linalg.norm(beside @ axes @ start - missing) > 1e-9 * (1.0 + np.linalg.norm(origin)):
            return None
        free = right[across:].T
        normals = self.normals @ self.axes.T @ axes @ free
        offsets = self.offsets - self.normals @ self.axes.T @ (origin + axes @ start - self.origin)
        size = np.linalg.norm(normals, axis=1)
        # A facet along the slice bounds nothing, unless all of the slice is beyond it.
        cuts = (size > 1e-12) | (offsets < -1e-9 * (1.0 + np.abs(self.offsets)))
        size = np.where(size > 1e-12, size, 1.0)
        return Polytope((normals / size[:, None])[cuts], (offsets / size)[cuts], start, free)

    @cached_property
    def vertices(self) -> np.ndarray:
        """Its corners, (k, d); none where nothing is inside."""
        d = self.dimension
        if d == 0:
            return np.zeros((0, len(self.origin))) if np.any(self.offsets < 0.0) else self.origin[None]
        if d == 1:
            low = -np.min(self.offsets[self.normals[:, 0] < 0.0])
            high = np.min(self.offsets[self.normals[:, 0] > 0.0])
            return self.origin + np.array([[low], [high]])[: 2 * (low < high)] @ self.axes.T
        spatial, optimize = extra_module("scipy.spatial"), extra_module("scipy.optimize")
        rows = np.column_stack([self.normals, np.ones(len(self.offsets))])
        bounds = [(None, None)] * d + [(0.0, None)]
        # The middle of the greatest ball inside.
        found = optimize.linprog([0.0] * d + [-1.0], A_ub=rows, b_ub=self.offsets, bounds=bounds)
        if found.status != 0 or found.x[d] <= 1e-9:
            return np.zeros((0, len(self.origin)))
        halves = np.column_stack([self.normals, -self.offsets])
        corners = spatial.HalfspaceIntersection(halves, found.x[:d]).intersections
        # A corner of more than d facets comes once for each choice of d of them.
        grid = 1e-7 * (1.0 + np.abs(corners).max())
        _, kept = np.unique(np.round(corners / grid), axis=0, return_index=True)
        return self.origin + corners[np.sort(kept)] @ self.axes.T

    @property
    def volume(self) -> float:
        """In its own dimensions; 0 of a point, and where nothing is inside."""
        corners = (self.vertices - self.origin) @ self.axes
        if self.dimension < 2 or not len(corners):
            return float(np.ptp(corners)) if corners.size else 0.0
        return float(extra_module("scipy.spatial").ConvexHull(corners).volume)

    def _split(self, vector: np.ndarray) -> tuple[np.ndarray, float]:
        """A vector (d,) in the polytope's own coordinates, and how far it leads out of its plane."""
        along = self.axes.T @ vector
        return along, float(np.linalg.norm(vector - self.axes @ along))


def zonotope(matrix: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> Polytope:
    """All Q x with lower <= x <= upper, for Q (d, n) and bounds (n,)."""
    basis = _basis(matrix)
    segments = basis.T @ matrix
    rank, n = segments.shape
    normals = np.ones((1, 1))
    if rank > 1:
        chosen = np.array(list(itertools.combinations(range(n), rank - 1)))
        _, sizes, right = np.linalg.svd(segments.T[chosen])  # of (m, rank - 1, rank)
        normals = right[sizes[:, -1] > _RANK * np.linalg.norm(segments), -1, :]
    normals = np.concatenate([normals, -normals])
    # The same facet comes once for each choice of its segments.
    normals = normals[np.unique(np.round(normals, 9), axis=0, return_index=True)[1]]
    heights = normals @ segments
    offsets = np.maximum(heights * lower, heights * upper).sum(axis=1)
    return Polytope(normals, offsets, np.zeros(len(matrix)), basis)


def zonotope_volume(matrix: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> float:
    """In its own dimensions: the sum, over all choices of so many segments, of the boxes that they span."""
    segments = _basis(matrix).T @ (matrix * (upper - lower))
    rank, n = segments.shape
    chosen = np.array(list(itertools.combinations(range(n), rank)), dtype=int)
    return float(np.abs(np.linalg.det(segments.T[chosen])).sum())


def _basis(matrix: np.ndarray) -> np.ndarray:
    """Orthonormal axes of the space that the columns of a matrix span, (d, rank)."""
    left, sizes, _ = np.linalg.svd(matrix, full_matrices=False)
    return left[:, sizes > _RANK * sizes[0]]
