"""A height map as a cubic B-spline on a regular grid: smooth in value, slope and curvature (`spline.c`)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skylimb.simulation.surfaces import bspline
from skylimb.simulation.surfaces.collision import native_text
from skylimb.simulation.surfaces.graph import Graph

_MARGIN = 12  # grid points; what happens that far beyond the border changes the surface by 1e-7 of itself


@dataclass(frozen=True, eq=False)
class Spline(Graph):
    """The shape that passes through heights on a grid.

    Attributes:
        coefficients: (nu, nv) of the B-spline, m, with one more row and column than the grid has on every
        side.
        pitch: of the grid, m; its middle is the origin.
    """

    coefficients: np.ndarray
    pitch: float

    @classmethod
    def through(cls, heights: np.ndarray, pitch: float) -> Spline:
        """The spline through `heights` (nu, nv), m, on a grid of `pitch` m that is centred on the origin.

        Beyond the border the surface goes on as its own half turn about the border, which keeps value and
        slope and leaves no curvature across it.
        """
        margin = min(_MARGIN, min(heights.shape) - 1)
        wide = np.pad(np.asarray(heights, dtype=float), margin, mode="reflect", reflect_type="odd")
        keep = slice(margin - 1, 1 - margin)
        return cls(bspline.coefficients(wide)[keep, keep], pitch)

    @property
    def at_origin(self) -> float:
        """The height at u = v = 0, m."""
        return float(self.on_grid(np.zeros(1), np.zeros(1))[0, 0])

    def on_grid(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """The heights on a grid within the extent, (len(u), len(v)), m: in NumPy, so without a C compiler."""
        places = [
            x / self.pitch + 0.5 * (n - 1) for x, n in zip((u, v), self.coefficients.shape, strict=True)
        ]
        return bspline.at_grid(self.coefficients, *places)

    @property
    def half_extent(self) -> tuple[float, float]:
        """Half of what the surface spans along u and v, m."""
        nu, nv = self.coefficients.shape
        return 0.5 * (nu - 3) * self.pitch, 0.5 * (nv - 3) * self.pitch

    @property
    def numbers(self) -> np.ndarray:
        """Counts, place of coefficient 0, pitch, and the coefficients."""
        nu, nv = self.coefficients.shape
        head = [nu, nv, -0.5 * (nu - 1) * self.pitch, -0.5 * (nv - 1) * self.pitch, self.pitch]
        return np.concatenate([head, self.coefficients.ravel()])

    @property
    def source(self) -> str:
        """The spline's weights, then Newton's method."""
        return native_text("spline.c") + native_text("graph.c")
