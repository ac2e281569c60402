"""A round post that is touched all around."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.simulation.surfaces.curved import CurvedSurface
from skylimb.simulation.surfaces.cylinder import round_geoms
from skylimb.simulation.surfaces.geom import Geom
from skylimb.simulation.surfaces.round import Round


@configuration
class Post(CurvedSurface):
    """A post or a pipe along v, of which back and sides are touched like its front.

    `position` is the point of its front where it touches its flat plane. A cylinder is the same to the
    physics; its analysis ends at its sides.
    """

    kind: Literal["post"] = "post"
    radius: Annotated[float, Key("m", "radius", low=0.01, high=1000.0)] = 0.3

    def make_shape(self) -> Round:
        """Round, all around."""
        return Round(self.radius)

    def drawn_u(self) -> np.ndarray:
        """Places along u of its front."""
        half = min(0.5 * self.size[0], 0.999 * self.radius)
        return np.linspace(-half, half, 121)

    def trace(self, points: np.ndarray, time: Any = None) -> tuple[np.ndarray, np.ndarray]:
        """Arc length all around, from -pi to pi times the radius, and v."""
        local = self.to_local(points, time)
        return self.radius * np.arctan2(local[..., 1], self.radius - local[..., 0]), local[..., 2]

    def covers(self, points: np.ndarray) -> np.ndarray:
        """Whether world points (..., 3) are not beyond its ends: some side of it faces all others."""
        return np.abs(self.to_local(points)[..., 2]) <= 0.5 * self.size[1]

    @property
    def geoms(self) -> tuple[Geom, ...]:
        """The engine's own cylinder."""
        return round_geoms(self.radius, self.size[1])
