"""What a curved shape must answer, to the analysis and to the collision function.

Axes: w into the surface, u and v along it. The robot is where w is below the surface.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

MARK = 7349205614.0
"""First number of every surface's data in a physics model, and user value of the geom that stands for it."""


class Shape(Protocol):
    """A curved surface in its own axes."""

    def height(self, u: ArrayLike, v: ArrayLike) -> np.ndarray:
        """The surface's w (m) at (u, v); NaN where there is none."""
        ...

    def closest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The surface points closest to points (..., 3) of (w, u, v), and the outward unit normals there."""
        ...

    def unrolled(self, u: ArrayLike) -> np.ndarray:
        """Length along the surface, m, from u = 0 to each u at v = 0."""
        ...

    def numbers(self) -> np.ndarray:
        """Kind and parameters as the collision function reads them, after the mark."""
        ...

    @property
    def tightest_hollow(self) -> float:
        """Smallest radius of curvature of a hollow, m, where a tip must fit; infinite if there is none."""
        ...
