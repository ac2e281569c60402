"""A sphere."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike

from skylimb.base.keys import Key, configuration
from skylimb.simulation.surfaces.curved import CurvedSurface
from skylimb.simulation.surfaces.geom import GEOM, Geom
from skylimb.simulation.surfaces.round import Round


@configuration
class Sphere(CurvedSurface):
    """A sphere that bulges toward the robot and touches its flat plane at the origin."""

    kind: Literal["sphere"] = "sphere"
    radius: Annotated[float, Key("m", "radius", low=0.01, high=1000.0)] = 1.0

    def make_shape(self) -> Round:
        """Round along u and v."""
        return Round(self.radius, ball=True)

    @property
    def _half_drawn(self) -> float:
        return min(0.5 * self.size[0], 0.5 * self.size[1], 0.7 * self.radius)

    def drawn_u(self) -> np.ndarray:
        """Places along u of a square on its front."""
        return np.linspace(-self._half_drawn, self._half_drawn, 61)

    def drawn_v(self) -> np.ndarray:
        """The same along v."""
        return self.drawn_u()

    def unroll(self, u: ArrayLike, v: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Great-circle distance from the origin, laid out in its own direction (u, v)."""
        u, v = np.asarray(u, dtype=float), np.asarray(v, dtype=float)
        flat = np.hypot(u, v)
        scale = np.where(flat > 0.0, self.shape.unrolled(flat) / np.maximum(flat, 1e-300), 1.0)
        return scale * u, scale * v

    @property
    def geoms(self) -> tuple[Geom, ...]:
        """The engine's own sphere."""
        return (Geom("sphere", [self.radius, 0.0, 0.0], [self.radius, 0.0, 0.0], name=GEOM),)
