"""A sphere."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from skylimb.keys import Key, configuration
from skylimb.simulation.surfaces.surface import COLOR, GEOM, Surface


@configuration
class Sphere(Surface):
    """A sphere that bulges toward the robot and touches its flat plane at the origin."""

    kind: Literal["sphere"] = "sphere"
    radius: Annotated[float, Key("m", "radius", low=0.01, high=1000.0)] = 1.0

    def height(self, u: ArrayLike, v: ArrayLike) -> np.ndarray:
        """Distance of the front half from the flat plane, m."""
        inside = self.radius**2 - np.asarray(u) ** 2 - np.asarray(v) ** 2
        return np.where(inside >= 0.0, self.radius - np.sqrt(np.maximum(inside, 0.0)), np.nan)

    def local_closest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The closest points lie on the ray from the centre."""
        centre = np.array([self.radius, 0.0, 0.0])
        ray = np.asarray(points, dtype=float) - centre
        length = np.linalg.norm(ray, axis=-1, keepdims=True)
        normal = np.where(length > 0.0, ray / np.maximum(length, 1e-300), np.array([-1.0, 0.0, 0.0]))
        return centre + self.radius * normal, normal

    def unroll(self, u: ArrayLike, v: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Great-circle distance from the origin, laid out in its own direction (u, v)."""
        u, v = np.asarray(u, dtype=float), np.asarray(v, dtype=float)
        flat = np.hypot(u, v)
        round_ = self.radius * np.arcsin(np.clip(flat / self.radius, 0.0, 1.0))
        scale = np.where(flat > 0.0, round_ / np.maximum(flat, 1e-300), 1.0)
        return scale * u, scale * v

    def add_geometry(self, spec: mujoco.MjSpec, body: mujoco.MjsBody) -> None:
        """The engine's own sphere."""
        common: dict[str, Any] = {
            "type": mujoco.mjtGeom.mjGEOM_SPHERE,
            "size": [self.radius, 0.0, 0.0],
            "pos": [self.radius, 0.0, 0.0],
            "contype": 0,
            "conaffinity": 0,
            "mass": 0.0,
        }
        body.add_geom(name=GEOM, group=1, rgba=COLOR, **common)

    def describe(self) -> dict[str, Any]:
        """As every surface's, with `u`, `v`, `height` and `unrolled_u` of a square on its front."""
        half = min(0.5 * self.size[0], 0.5 * self.size[1], 0.7 * self.radius)
        u = np.linspace(-half, half, 61)
        return super().describe() | {
            "u": u.round(6).tolist(),
            "v": u.round(6).tolist(),
            "height": self.height(u[:, None], u[None, :]).round(6).tolist(),
            "unrolled_u": self.unroll(u, np.zeros_like(u))[0].round(6).tolist(),
        }
