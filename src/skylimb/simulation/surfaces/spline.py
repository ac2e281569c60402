"""A height map as a cubic B-spline on a regular grid: smooth in value, slope and curvature."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skylimb.simulation.surfaces.graph import Graph

KIND = 3.0
_MARGIN = 12  # grid points; what happens that far beyond the border changes the surface by 1e-7 of itself


@dataclass(frozen=True, eq=False)
class Spline(Graph):
    """The shape that passes through heights on a grid.

    Attributes:
        coefficients: (nu, nv) of the B-spline, m, with one more row and column than the grid has on every
        side.
        u0: u of coefficient 0, m.
        v0: v of coefficient 0, m.
        pitch: of the grid, m.
    """

    coefficients: np.ndarray
    u0: float
    v0: float
    pitch: float

    @classmethod
    def through(cls, heights: np.ndarray, pitch: float) -> Spline:
        """The spline through `heights` (nu, nv), m, on a grid of `pitch` m that is centred on the origin.

        Beyond the border the surface goes on as its own half turn about the border, which keeps value and
        slope and leaves no curvature across it.
        """
        from scipy.ndimage import spline_filter  # slow to import, and few surfaces are splines

        margin = min(_MARGIN, min(heights.shape) - 1)
        wide = np.pad(np.asarray(heights, dtype=float), margin, mode="reflect", reflect_type="odd")
        coefficients = spline_filter(wide, order=3, mode="mirror")
        keep = slice(margin - 1, 1 - margin)
        nu, nv = heights.shape
        u0, v0 = -(0.5 * (nu - 1) + 1) * pitch, -(0.5 * (nv - 1) + 1) * pitch
        return cls(coefficients[keep, keep], u0, v0, pitch)

    @property
    def half_extent(self) -> tuple[float, float]:
        """Half of what the surface spans along u and v, m."""
        nu, nv = self.coefficients.shape
        return 0.5 * (nu - 3) * self.pitch, 0.5 * (nv - 3) * self.pitch

    def derivatives(self, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, ...]:
        """h, h_u, h_v, h_uu, h_uv, h_vv at (u, v); beyond the grid the border's slope goes on."""
        half_u, half_v = self.half_extent
        inner_u, inner_v = np.clip(u, -half_u, half_u), np.clip(v, -half_v, half_v)
        h, hu, hv, huu, huv, hvv = self._inside(inner_u, inner_v)
        du, dv = u - inner_u, v - inner_v
        h = h + hu * du + hv * dv + huv * du * dv
        return h, hu + huv * dv, hv + huv * du, huu * (du == 0.0), huv, hvv * (dv == 0.0)

    def _inside(self, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, ...]:
        nu, nv = self.coefficients.shape
        x, y = (np.asarray(u) - self.u0) / self.pitch, (np.asarray(v) - self.v0) / self.pitch
        # The last grid line belongs to the cell before it.
        i = np.clip(np.floor(x).astype(int), 1, nu - 3)
        j = np.clip(np.floor(y).astype(int), 1, nv - 3)
        bu, bv = _basis(x - i), _basis(y - j)
        window = np.arange(-1, 3)
        c = self.coefficients[i[..., None, None] + window[:, None], j[..., None, None] + window]

        def part(a: int, b: int) -> np.ndarray:
            value = np.einsum("...a,...ab,...b->...", bu[a], c, bv[b])
            return value / self.pitch ** (a + b)

        return part(0, 0), part(1, 0), part(0, 1), part(2, 0), part(1, 1), part(0, 2)

    def numbers(self) -> np.ndarray:
        """Kind and parameters as the collision function reads them."""
        nu, nv = self.coefficients.shape
        head = [KIND, nu, nv, self.u0, self.v0, self.pitch]
        return np.concatenate([head, self.coefficients.ravel()])


def _basis(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The four cubic B-spline weights at t in a cell (..., 4), their first and second derivatives in t."""
    s = 1.0 - t
    value = [s**3, 3 * t**3 - 6 * t**2 + 4, 3 * s**3 - 6 * s**2 + 4, t**3]
    first = [-3 * s**2, 9 * t**2 - 12 * t, -(9 * s**2 - 12 * s), 3 * t**2]
    second = [6 * s, 18 * t - 12, 18 * s - 12, 6 * t]
    stacked = [np.stack(rows, axis=-1) / 6.0 for rows in (value, first, second)]
    return stacked[0], stacked[1], stacked[2]
