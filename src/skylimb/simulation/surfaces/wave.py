"""A sine drawn out along v: w = a sin(k u + phase) - a sin(phase), so that the origin lies on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skylimb.simulation.surfaces.graph import Graph

KIND = 2.0


@dataclass(frozen=True)
class Wave(Graph):
    """The shape of a sine.

    Attributes:
        amplitude: a, m.
        wavelength: 2 pi / k, m.
        phase: rad.
        half_u: half of what is looked at along u, m; the wave itself has no end.
        half_v: the same along v, m.
    """

    amplitude: float
    wavelength: float
    phase: float
    half_u: float
    half_v: float

    @property
    def wave_number(self) -> float:
        """Wave number k, rad/m."""
        return 2.0 * np.pi / self.wavelength

    @property
    def half_extent(self) -> tuple[float, float]:
        """Half of what the surface spans along u and v, m."""
        return self.half_u, self.half_v

    def derivatives(self, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, ...]:
        """h, h_u, h_v, h_uu, h_uv, h_vv at (u, v)."""
        a, k = self.amplitude, self.wave_number
        angle = k * u + self.phase
        s, c = np.sin(angle), np.cos(angle)
        zero = np.zeros_like(s)
        return a * s - a * np.sin(self.phase), a * k * c, zero, -a * k * k * s, zero, zero

    @property
    def tightest_hollow(self) -> float:
        """The radius of curvature at a trough, 1 / (a k^2), m."""
        return 1.0 / (self.amplitude * self.wave_number**2) if self.amplitude else float("inf")

    def numbers(self) -> np.ndarray:
        """Kind and parameters as the collision function reads them."""
        offset = -self.amplitude * np.sin(self.phase)
        return np.array([KIND, self.amplitude, self.wave_number, self.phase, offset])
