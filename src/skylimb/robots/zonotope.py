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

_RANK = 1e-9
"""Singular values below this share of the greatest are none."""


@dataclass(frozen=True)
class Polytope:
    """All points x with normals x <= offsets.

    Attributes:
        normals: outward unit normals of the facets, (m, d).
        offsets: distance of each facet from the origin along its normal, (m,).
    """

    normals: np.ndarray
    offsets: np.ndarray

    @property
    def dimension(self) -> int:
        """D."""
        return self.normals.shape[1]

    def margin(self, point: np.ndarray) -> float:
        """Distance of a point (d,) to the nearest facet; negative outside."""
        return float(np.min(self.offsets - self.normals @ point, initial=np.inf))

    def reach(self, point: np.ndarray, direction: np.ndarray) -> float:
        """The greatest t for which point + t direction is inside; NaN from a point outside of it."""
        room, speed = self.offsets - self.normals @ point, self.normals @ direction
        if np.any(room < -1e-9 * (1.0 + np.abs(self.offsets))):
            return float("nan")
        ahead = speed > 1e-12 * np.linalg.norm(direction)
        return float(np.min(np.maximum(room[ahead], 0.0) / speed[ahead], initial=np.inf))

    @cached_property
    def center(self) -> np.ndarray | None:
        """Middle of the greatest ball inside, (d,); None where nothing is inside."""
        from scipy.optimize import linprog  # slow to import

        d = self.dimension
        rows = np.column_stack([self.normals, np.ones(len(self.offsets))])
        bounds = [(None, None)] * d + [(0.0, None)]
        found = linprog([0.0] * d + [-1.0], A_ub=rows, b_ub=self.offsets, bounds=bounds, method="highs")
        return found.x[:d] if found.status == 0 and found.x[d] > 1e-9 else None

    @cached_property
    def vertices(self) -> np.ndarray:
        """(k, d); empty where nothing is inside."""
        from scipy.spatial import HalfspaceIntersection

        center = self.center
        if center is None:
            return np.zeros((0, self.dimension))
        if self.dimension == 1:
            ends = np.sort([self.reach(center, np.array([-1.0])) * -1.0, self.reach(center, np.array([1.0]))])
            return (center + ends)[:, None]
        corners = HalfspaceIntersection(np.column_stack([self.normals, -self.offsets]), center).intersections
        # A corner of more than d facets comes once for each choice of d of them.
        grid = 1e-7 * (1.0 + np.abs(corners).max())
        _, kept = np.unique(np.round(corners / grid), axis=0, return_index=True)
        return corners[np.sort(kept)]

    @cached_property
    def volume(self) -> float:
        """In its own d dimensions."""
        from scipy.spatial import ConvexHull

        vertices = self.vertices
        if len(vertices) == 0:
            return 0.0
        if self.dimension == 1:
            return float(np.ptp(vertices))
        return float(ConvexHull(vertices).volume)

    def section(self, origin: np.ndarray, axes: np.ndarray) -> Polytope:
        """Its slice in the coordinates y of origin + axes y, for origin (d,) and axes (d, k)."""
        normals, offsets = self.normals @ axes, self.offsets - self.normals @ origin
        size = np.linalg.norm(normals, axis=1)
        # A facet along the slice bounds nothing, unless all of the slice is beyond it.
        cuts = (size > 1e-12) | (offsets < -1e-9 * (1.0 + np.abs(self.offsets)))
        size = np.where(size > 1e-12, size, 1.0)
        return Polytope((normals / size[:, None])[cuts], (offsets / size)[cuts])


@dataclass(frozen=True)
class Zonotope:
    """All Q x with lower <= x <= upper, in the space that the columns of Q span.

    Attributes:
        matrix: Q, (d, n).
        lower, upper: bounds, (n,) each.
    """

    matrix: np.ndarray
    lower: np.ndarray
    upper: np.ndarray

    @cached_property
    def basis(self) -> np.ndarray:
        """Orthonormal axes of the space that Q spans, (d, rank)."""
        left, sizes, _ = np.linalg.svd(self.matrix, full_matrices=False)
        return left[:, sizes > _RANK * sizes[0]]

    @property
    def rank(self) -> int:
        """Of Q."""
        return self.basis.shape[1]

    @cached_property
    def inside(self) -> Polytope:
        """In the coordinates of `basis`."""
        segments = self.basis.T @ self.matrix
        rank, n = segments.shape
        normals = np.ones((1, 1))
        if rank > 1:
            chosen = np.array(list(itertools.combinations(range(n), rank - 1)))
            _, sizes, right = np.linalg.svd(segments.T[chosen])  # of (m, rank - 1, rank)
            normals = right[sizes[:, -1] > _RANK * np.linalg.norm(segments), -1, :]
        normals = np.concatenate([normals, -normals])
        # The same facet comes once for each choice of its segments.
        normals = normals[np.unique(np.round(normals, 9), axis=0, return_index=True)[1]]
        return Polytope(normals, self._support(normals @ segments))

    @cached_property
    def volume(self) -> float:
        """In its own dimensions: the sum over all choices of `rank` segments of the boxes that they span."""
        segments = self.basis.T @ (self.matrix * (self.upper - self.lower))
        rank, n = segments.shape
        chosen = np.array(list(itertools.combinations(range(n), rank)), dtype=int)
        return float(np.abs(np.linalg.det(segments.T[chosen])).sum())

    @cached_property
    def vertices(self) -> np.ndarray:
        """(k, d), of at most 12 segments.

        Raises:
            ValueError: for more.
        """
        from scipy.spatial import ConvexHull

        n = self.matrix.shape[1]
        if n > 12:
            raise ValueError(f"corners of a zonotope of {n} segments are too many")
        corners = np.array(list(itertools.product(*zip(self.lower, self.upper, strict=True)))) @ self.matrix.T
        if self.rank == 1:
            along = (corners @ self.basis).ravel()
            return corners[[int(along.argmin()), int(along.argmax())]]
        return corners[ConvexHull(corners @ self.basis).vertices]

    def margin(self, point: np.ndarray) -> float:
        """Distance of a point (d,) to the nearest facet; 0 or less outside, also beside a flat one."""
        if self._beside(point) > 1e-9 * (1.0 + np.linalg.norm(point)):
            return -self._beside(point)
        return self.inside.margin(self.basis.T @ point)

    def reach(self, point: np.ndarray, direction: np.ndarray) -> float:
        """The greatest t for which point + t direction is inside; NaN from a point outside of it."""
        if self._beside(point) > 1e-9 * (1.0 + np.linalg.norm(point)):
            return float("nan")
        farther = self.inside.reach(self.basis.T @ point, self.basis.T @ direction)
        leaves = self._beside(direction) > 1e-9 * np.linalg.norm(direction)
        return 0.0 if leaves and not np.isnan(farther) else farther

    def section(self, origin: np.ndarray, axes: np.ndarray) -> Slice | None:
        """Its slice in the plane of all origin + axes y, origin (d,), axes (d, k); None if it misses."""
        beside = np.eye(len(origin)) - self.basis @ self.basis.T
        left, sizes, right = np.linalg.svd(beside @ axes)
        held = int(np.sum(sizes > 1e-9 * (1.0 + np.linalg.norm(axes))))
        missing = -beside @ origin
        start = right[:held].T @ ((left[:, :held].T @ missing) / sizes[:held])
        if np.linalg.norm(beside @ axes @ start - missing) > 1e-9 * (1.0 + np.linalg.norm(origin)):
            return None
        free = right[held:].T
        inside = self.inside.section(self.basis.T @ (origin + axes @ start), self.basis.T @ axes @ free)
        return Slice(start, free, inside)

    def _beside(self, vector: np.ndarray) -> float:
        return float(np.linalg.norm(vector - self.basis @ (self.basis.T @ vector)))

    def _support(self, heights: np.ndarray) -> np.ndarray:
        """Greatest height over the box, for the height of a unit of each segment, (m, n)."""
        return np.maximum(heights * self.lower, heights * self.upper).sum(axis=1)


@dataclass(frozen=True)
class Slice:
    """A slice of a zonotope, in the k coordinates y of its plane; it may have fewer dimensions than that.

    Attributes:
        origin: (k,) a point of it.
        axes: (k, dimension) orthonormal directions in which it extends.
        inside: in the coordinates of `axes`, from `origin`.
    """

    origin: np.ndarray
    axes: np.ndarray
    inside: Polytope

    @property
    def dimension(self) -> int:
        """In how many directions it extends."""
        return self.axes.shape[1]

    @property
    def vertices(self) -> np.ndarray:
        """(m, k)."""
        if self.dimension == 0:
            empty = np.any(self.inside.offsets < 0.0)
            return np.zeros((0, len(self.origin))) if empty else self.origin[None]
        return self.origin + self.inside.vertices @ self.axes.T

    @property
    def volume(self) -> float:
        """In its own dimensions; 0 of a point."""
        return self.inside.volume if self.dimension else 0.0

    def margin(self, point: np.ndarray) -> float:
        """Distance of a point y (k,) to the nearest facet; 0 where the slice has no inside."""
        if self.dimension < len(self.origin):
            return 0.0
        return self.inside.margin(self.axes.T @ (point - self.origin))

    def reach(self, direction: np.ndarray) -> float:
        """The greatest t for which t direction (k,) is in it; NaN where y = 0 is not, 0 beside its extent."""
        start = -self.axes.T @ self.origin
        if np.linalg.norm(self.origin + self.axes @ start) > 1e-7:
            return float("nan")
        along = self.axes.T @ direction
        if self.dimension == 0 or np.linalg.norm(direction - self.axes @ along) > 1e-7 * np.linalg.norm(
            direction
        ):
            return 0.0
        return self.inside.reach(start, along)
