"""A round post that is touched all around."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from skylimb.keys import Key, configuration
from skylimb.simulation.surfaces.cylinder import add_round
from skylimb.simulation.surfaces.surface import Surface

_ROUNDING = 1e-9


@configuration
class Post(Surface):
    """A post or a pipe along v, of which back and sides are touched like its front.

    `position` is the point of its front where it touches its flat plane. A cylinder is the same to the
    physics; its analysis ends at its sides.
    """

    kind: Literal["post"] = "post"
    radius: Annotated[float, Key("m", "radius", low=0.01, high=1000.0)] = 0.3

    def height(self, u: ArrayLike, v: ArrayLike) -> np.ndarray:
        """Distance of the front from the flat plane, m."""
        inside = self.radius**2 - np.asarray(u, dtype=float) ** 2 + 0.0 * np.asarray(v)
        front = self.radius - np.sqrt(np.maximum(inside, 0.0))
        return np.where(inside >= -_ROUNDING * self.radius**2, front, np.nan)

    def local_closest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The closest points lie on the ray from the axis."""
        points = np.asarray(points, dtype=float)
        ray = points - np.stack(
            [np.full(points.shape[:-1], self.radius), np.zeros(points.shape[:-1]), points[..., 2]], axis=-1
        )
        length = np.linalg.norm(ray, axis=-1, keepdims=True)
        normal = np.where(length > 0.0, ray / np.maximum(length, 1e-300), np.array([-1.0, 0.0, 0.0]))
        return points - ray + self.radius * normal, normal

    def unroll(self, u: ArrayLike, v: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Arc length of the front from the origin, and v."""
        ratio = np.clip(np.asarray(u, dtype=float) / self.radius, -1.0, 1.0)
        return self.radius * np.arcsin(ratio), np.asarray(v, dtype=float)

    def trace(self, points: np.ndarray, time: Any = None) -> tuple[np.ndarray, np.ndarray]:
        """Arc length all around, from -pi to pi times the radius, and v."""
        local = self.to_local(points, time)
        return self.radius * np.arctan2(local[..., 1], self.radius - local[..., 0]), local[..., 2]

    def covers(self, points: np.ndarray, time: Any = None) -> np.ndarray:
        """Whether world points (..., 3) are not beyond its ends: some side of it faces all others."""
        return np.abs(self.to_local(points, time)[..., 2]) <= 0.5 * self.size[1]

    def add_geometry(self, spec: mujoco.MjSpec, body: mujoco.MjsBody) -> None:
        """The engine's own cylinder."""
        add_round(body, self.radius, self.size[1])

    def describe(self) -> dict[str, Any]:
        """As every surface's, with `u`, `v`, `height` and `unrolled_u` of its front."""
        half = min(0.5 * self.size[0], 0.999 * self.radius)
        u = np.linspace(-half, half, 121)
        v = np.array([-0.5, 0.5]) * self.size[1]
        return super().describe() | {
            "u": u.round(6).tolist(),
            "v": v.round(6).tolist(),
            "height": self.height(u[:, None], v[None, :]).round(6).tolist(),
            "unrolled_u": self.unroll(u, np.zeros_like(u))[0].round(6).tolist(),
        }
