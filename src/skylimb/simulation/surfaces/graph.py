"""Surfaces that are the graph of a smooth function, w = h(u, v): the closest point by Newton's method."""

from __future__ import annotations

import abc

import numpy as np
from numpy.typing import ArrayLike

_SAMPLES = 2001  # of an arc length


class Graph(abc.ABC):
    """A shape given by h and its derivatives."""

    @abc.abstractmethod
    def derivatives(self, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, ...]:
        """h, h_u, h_v, h_uu, h_uv, h_vv at any (u, v); smooth beyond the surface's extent as well."""

    @property
    @abc.abstractmethod
    def half_extent(self) -> tuple[float, float]:
        """Half of what the surface spans along u and v, m."""

    def height(self, u: ArrayLike, v: ArrayLike) -> np.ndarray:
        """The surface's w (m) at (u, v)."""
        u, v = np.broadcast_arrays(np.asarray(u, dtype=float), np.asarray(v, dtype=float))
        return self.derivatives(u, v)[0]

    def closest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The surface points closest to points (..., 3) of (w, u, v), and the outward unit normals there.

        The distance |(h - w, u' - u, v' - v)| is made least over (u', v'), from the foot along w. Newton's
        matrix is replaced by its part that is always positive where it is not positive itself, and a step
        that does not come closer is halved.
        """
        points = np.asarray(points, dtype=float)
        w, u0, v0 = points[..., 0], points[..., 1], points[..., 2]
        u, v = u0.copy(), v0.copy()
        h = self.derivatives(u, v)
        cost = (h[0] - w) ** 2
        for _ in range(60):
            e = h[0] - w
            gu, gv = u - u0 + e * h[1], v - v0 + e * h[2]
            su, sv = _newton_step(e, gu, gv, h)
            scale = np.ones_like(u)
            tried, tried_cost = h, cost
            for _ in range(30):
                tried = self.derivatives(u - scale * su, v - scale * sv)
                tried_cost = (tried[0] - w) ** 2 + (u - scale * su - u0) ** 2 + (v - scale * sv - v0) ** 2
                worse = tried_cost > cost * (1.0 + 1e-14) + 1e-30
                if not np.any(worse):
                    break
                scale = np.where(worse, 0.5 * scale, scale)
            u, v, h, cost = u - scale * su, v - scale * sv, tried, np.minimum(cost, tried_cost)
            if np.all(scale * scale * (su * su + sv * sv) < 1e-26):
                break
        foot = np.stack([h[0], u, v], axis=-1)
        normal = np.stack([-np.ones_like(u), h[1], h[2]], axis=-1)
        return foot, normal / np.linalg.norm(normal, axis=-1, keepdims=True)

    def unrolled(self, u: ArrayLike) -> np.ndarray:
        """Length along the surface, m, from u = 0 to each u at v = 0."""
        half = self.half_extent[0]
        grid = np.linspace(-half, half, _SAMPLES)
        slope = self.derivatives(grid, np.zeros_like(grid))[1]
        rate = np.sqrt(1.0 + slope**2)
        length = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(grid))])
        length -= np.interp(0.0, grid, length)
        return np.interp(np.asarray(u, dtype=float), grid, length)

    @property
    def tightest_hollow(self) -> float:
        """Smallest radius of curvature of a hollow, m, found on a dense sample; infinite if none."""
        half_u, half_v = self.half_extent
        u, v = np.meshgrid(
            np.linspace(-half_u, half_u, 401), np.linspace(-half_v, half_v, 401), indexing="ij"
        )
        _, hu, hv, huu, huv, hvv = self.derivatives(u, v)
        # Principal curvatures from the first and second fundamental forms; positive bends away from the
        # robot.
        root = np.sqrt(1.0 + hu**2 + hv**2)
        E, F, G = 1.0 + hu**2, hu * hv, 1.0 + hv**2
        gauss = (huu * hvv - huv**2) / root**4
        mean = (E * hvv - 2.0 * F * huv + G * huu) / (2.0 * root**3)
        # w grows into the surface, so a hollow (seen from the robot) is where h has a maximum.
        hollow = -mean + np.sqrt(np.maximum(mean**2 - gauss, 0.0))
        most = float(np.max(hollow))
        return 1.0 / most if most > 1e-9 else float("inf")


def _newton_step(
    e: np.ndarray, gu: np.ndarray, gv: np.ndarray, h: tuple[np.ndarray, ...]
) -> tuple[np.ndarray, np.ndarray]:
    _, hu, hv, huu, huv, hvv = h
    a, b, c = 1.0 + hu**2, hu * hv, 1.0 + hv**2
    A, B, C = a + e * huu, b + e * huv, c + e * hvv
    good = (0.1 * a < A) & (0.1 * (a * c - b * b) < A * C - B * B)
    A, B, C = np.where(good, A, a), np.where(good, B, b), np.where(good, C, c)
    det = A * C - B * B
    return (C * gu - B * gv) / det, (A * gv - B * gu) / det
