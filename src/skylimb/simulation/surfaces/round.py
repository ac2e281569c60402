"""Round shapes that the engine has itself: a cylinder along v, and a ball."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from skylimb.simulation.surfaces.shape import Shape

_ROUNDING = 1e-9


@dataclass(frozen=True)
class Round(Shape):
    """A cylinder or a ball behind the origin, which touches it.

    Attributes:
        radius: m.
        ball: whether it is round along v as well.
    """

    radius: float
    ball: bool = False

    def closest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The closest points lie on the ray from the axis, or from the centre."""
        ray = np.asarray(points, dtype=float) - [self.radius, 0.0, 0.0]
        if not self.ball:
            ray[..., 2] = 0.0
        length = np.linalg.norm(ray, axis=-1, keepdims=True)
        normal = np.where(length > 0.0, ray / np.maximum(length, 1e-300), np.array([-1.0, 0.0, 0.0]))
        return points - ray + self.radius * normal, normal

    def height(self, u: ArrayLike, v: ArrayLike) -> np.ndarray:
        """Distance of the front half from the flat plane, m."""
        v = np.asarray(v, dtype=float)
        inside = self.radius**2 - np.asarray(u, dtype=float) ** 2 - (v**2 if self.ball else 0.0 * v)
        front = self.radius - np.sqrt(np.maximum(inside, 0.0))
        return np.where(inside >= -_ROUNDING * self.radius**2, front, np.nan)

    def unrolled(self, u: ArrayLike) -> np.ndarray:
        """Arc length of the front from the origin."""
        return self.radius * np.arcsin(np.clip(np.asarray(u, dtype=float) / self.radius, -1.0, 1.0))
