"""Surfaces that are the graph of a smooth function, w = h(u, v); `graph.c` finds their closest points."""

from __future__ import annotations

import abc
from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from skylimb.base.packing import Layout
from skylimb.simulation.surfaces.collision import native_text
from skylimb.simulation.surfaces.shape import NativeShape, c_of_heights

SAMPLES = 2001  # of an arc length


class Graph(NativeShape):
    """A shape given by h and its derivatives; smooth beyond the surface's extent as well."""

    @property
    @abc.abstractmethod
    def half_extent(self) -> tuple[float, float]:
        """Half of what the surface spans along u and v, m."""

    def derivatives(self, u: ArrayLike, v: ArrayLike) -> np.ndarray:
        """h, h_u, h_v, h_uu, h_uv, h_vv (6, ...) at any (u, v)."""
        return np.moveaxis(self.native.heights(self.numbers, u, v), -1, 0)

    def height(self, u: ArrayLike, v: ArrayLike) -> np.ndarray:
        """The surface's w (m) at (u, v)."""
        return self.derivatives(u, v)[0]

    def unrolled(self, u: ArrayLike) -> np.ndarray:
        """Length along the surface, m, from u = 0 to each u at v = 0."""
        half = self.half_extent[0]
        grid = np.linspace(-half, half, SAMPLES)
        rate = np.sqrt(1.0 + self.derivatives(grid, np.zeros_like(grid))[1] ** 2)
        return arc_length(u, grid, 0.5 * (rate[1:] + rate[:-1]) * np.diff(grid))

    @property
    def tightest_hollow(self) -> float:
        """Smallest radius of curvature of a hollow, m, found on a dense sample; infinite if none."""
        half_u, half_v = self.half_extent
        u, v = np.linspace(-half_u, half_u, 401), np.linspace(-half_v, half_v, 401)
        return tightest_hollow(self.derivatives(*np.meshgrid(u, v, indexing="ij")))


class Formula(Graph):
    """A graph whose height is written in symbols (`skylimb.symbolic`); CasADi's derivatives are exact.

    Args:
        height: h(u, v, keys), m, or a tuple of h, h_u, h_v, h_uu, h_uv, h_vv; the surface is shifted along w
            so that the origin lies on it.
        keys: a record of the numbers in it, whatever `skylimb.base.packing` takes.
        half_extent: half of what is looked at along u and v, m; the surface itself has no end.
    """

    def __init__(
        self, height: Callable[[Any, Any, Any], Any], keys: Any, half_extent: tuple[float, float]
    ) -> None:
        layout = Layout(keys)
        u, v, p = ca.SX.sym("u"), ca.SX.sym("v"), ca.SX.sym("numbers", layout.size + 1)
        found = height(u, v, layout.unpack(p[:-1]))
        six = list(found) if isinstance(found, tuple) else _with_derivatives(ca.SX(found), u, v)
        six[0] = six[0] - p[-1]
        self.function = ca.Function("shape", [p, u, v], [ca.densify(ca.vertcat(*six))], {"cse": True})
        packed = layout.pack(keys)
        self._numbers = np.append(packed, float(self.function(np.append(packed, 0.0), 0.0, 0.0)[0]))
        self._half_extent = half_extent

    @property
    def half_extent(self) -> tuple[float, float]:
        """Half of what is looked at along u and v, m."""
        return self._half_extent

    @property
    def numbers(self) -> np.ndarray:
        """The keys' numbers, and the height at the origin that is taken off."""
        return self._numbers

    @property
    def source(self) -> str:
        """The formula and its derivatives, then Newton's method."""
        return c_of_heights(self.function) + native_text("graph.c")


def _with_derivatives(h: ca.SX, u: ca.SX, v: ca.SX) -> list[ca.SX]:
    """h, h_u, h_v, h_uu, h_uv, h_vv."""
    slopes = ca.gradient(h, ca.vertcat(u, v))
    bends = ca.jacobian(slopes, ca.vertcat(u, v))
    return [h, slopes[0], slopes[1], bends[0, 0], bends[0, 1], bends[1, 1]]


def arc_length(u: ArrayLike, grid: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Length along a line, m, from u = 0 to each u, where `steps` are the lengths between a grid's places."""
    length = np.concatenate([[0.0], np.cumsum(steps)])
    return np.interp(np.asarray(u, dtype=float), grid, length - np.interp(0.0, grid, length))


def tightest_hollow(derivatives: np.ndarray) -> float:
    """Smallest radius of curvature of a hollow, m, of h, h_u, h_v, h_uu, h_uv, h_vv (6, ...) at some places.

    A NaN counts as a place without a surface.
    """
    _, hu, hv, huu, huv, hvv = derivatives
    # Principal curvatures from the first and second fundamental forms; positive bends away from the robot.
    root = np.sqrt(1.0 + hu**2 + hv**2)
    E, F, G = 1.0 + hu**2, hu * hv, 1.0 + hv**2
    gauss = (huu * hvv - huv**2) / root**4
    mean = (E * hvv - 2.0 * F * huv + G * huu) / (2.0 * root**3)
    # w grows into the surface, so a hollow (seen from the robot) is where h has a maximum.
    most = float(np.nanmax(-mean + np.sqrt(np.maximum(mean**2 - gauss, 0.0)), initial=0.0))
    return 1.0 / most if most > 1e-9 else float("inf")
