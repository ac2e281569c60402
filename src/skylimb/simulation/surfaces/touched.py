"""What a contact is held against: a surface that stays, or one that is elsewhere at every tick."""

from __future__ import annotations

import abc
from typing import Any

import numpy as np
from numpy.typing import ArrayLike


class Touched(abc.ABC):
    """A surface over time. Points are (..., 3) in W, m, times (...) in s, None for a surface at rest."""

    @abc.abstractmethod
    def unroll(self, u: ArrayLike, v: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Lengths along the surface at (u, v), m, as a ruler laid on it reads them."""

    @abc.abstractmethod
    def velocity(self, time: Any) -> np.ndarray:
        """Velocity (..., 3) with which it moves by itself at times (...), W, m/s."""

    @abc.abstractmethod
    def nearest(self, points: np.ndarray, time: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Points, closest points and outward normals there in the surface's own axes, (..., 3) each."""

    @abc.abstractmethod
    def in_world(self, vectors: np.ndarray, time: Any) -> np.ndarray:
        """Vectors (..., 3) of the surface's own axes in those of W."""

    def signed_distance(self, points: np.ndarray, time: Any = None) -> np.ndarray:
        """Distance (...) of world points from the surface, m; negative behind it."""
        local, foot, normal = self.nearest(points, time)
        return np.sum((local - foot) * normal, axis=-1)

    def normal(self, points: np.ndarray, time: Any = None) -> np.ndarray:
        """Outward unit normal (..., 3), W, at the surface points closest to world points."""
        return self.in_world(self.nearest(points, time)[2], time)

    def trace(self, points: np.ndarray, time: Any = None) -> tuple[np.ndarray, np.ndarray]:
        """Unrolled coordinates (s, t), m, of the surface points closest to world points."""
        foot = self.nearest(points, time)[1]
        return self.unroll(foot[..., 1], foot[..., 2])
