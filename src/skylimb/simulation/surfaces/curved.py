"""A surface with a shape of its own: it goes through the collision function, and is looked at as a mesh."""

from __future__ import annotations

import abc
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from skylimb.base.keys import configuration
from skylimb.simulation.surfaces.geom import GEOM, Geom, Shaped, Sheet
from skylimb.simulation.surfaces.shape import NativeShape, Shape
from skylimb.simulation.surfaces.surface import Surface

_DRAWN, _DRAWN_BOTH = 121, 81  # points along u; along u and v where the shape changes along both
FAR = 30.0
"""How far, in m, the contact goes on beyond what is looked at, so that no edge is met from behind."""

_THICKNESS = 0.02  # m, of what is looked at


@configuration
class CurvedSurface(Surface, abc.ABC):
    """A surface with a `Shape`."""

    curved_along_v: ClassVar[bool] = False
    """Whether the shape also changes along v; if not it is drawn with two points along it."""

    @abc.abstractmethod
    def make_shape(self) -> Shape:
        """The shape in the surface's own axes."""

    @cached_property
    def shape(self) -> Shape:
        """The shape; it is made once."""
        return self.make_shape()

    def __getstate__(self) -> dict[str, Any]:
        # A library that is loaded here cannot be handed to another process, which makes the shape anew.
        return {name: value for name, value in vars(self).items() if name != "shape"}

    def drawn_u(self) -> np.ndarray:
        """(n,) places along u, m, at which the surface is drawn and recorded."""
        return np.linspace(-0.5, 0.5, _DRAWN_BOTH if self.curved_along_v else _DRAWN) * self.size[0]

    def drawn_v(self) -> np.ndarray:
        """(m,) places along v, m, at which the surface is drawn and recorded."""
        return np.linspace(-0.5, 0.5, _DRAWN_BOTH if self.curved_along_v else 2) * self.size[1]

    def height(self, u: ArrayLike, v: ArrayLike) -> np.ndarray:
        """The shape's w at (u, v), m; NaN where there is none."""
        return self.shape.height(u, v)

    def local_closest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The shape's closest points and outward normals."""
        return self.shape.closest(points)

    def unroll(self, u: ArrayLike, v: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Length along the surface at v = 0, and v."""
        return self.shape.unrolled(np.asarray(u, dtype=float)), np.asarray(v, dtype=float)

    @property
    def tightest_hollow(self) -> float:
        """Smallest radius of curvature of a hollow of the shape, m; infinite if there is none."""
        return self.shape.tightest_hollow

    @property
    def geoms(self) -> tuple[Geom, ...]:
        """An ellipsoid that stands for the shape in the collision function, and a mesh to look at."""
        shape = self.shape
        assert isinstance(shape, NativeShape)  # the engine has all others itself
        shaped = Shaped(shape.native.mark, shape.numbers, shape.native.library)
        # Of the ellipsoid only its bounding sphere counts.
        touched = Geom("ellipsoid", [FAR] * 3, name=GEOM, color=None, shaped=shaped)
        return touched, Geom("mesh", sheet=sheet(*self.drawn))

    @cached_property
    def drawn(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Grids u (n,), v (m,) and height w (n, m) on them, m: what is looked at and recorded."""
        # A hair inside of the border, where the height is sure to exist.
        u, v = self.drawn_u() * (1.0 - 1e-9), self.drawn_v() * (1.0 - 1e-9)
        return u, v, self.height(u[:, None], v[None, :])

    def describe(self) -> dict[str, Any]:
        """As every surface's, with `u`, `v`, `height` and `unrolled_u`."""
        u, v, w = self.drawn
        return super().describe() | {
            "u": u.round(6).tolist(),
            "v": v.round(6).tolist(),
            "height": w.round(6).tolist(),
            "unrolled_u": self.unroll(u, np.zeros_like(u))[0].round(6).tolist(),
        }


def sheet(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> Sheet:
    """A sheet w(u, v) with a back side; points without a height are left out."""
    n, m = w.shape
    grid_u, grid_v = np.meshgrid(u, v, indexing="ij")
    front = np.stack([w, grid_u, grid_v], axis=-1).reshape(-1, 3)
    there = np.isfinite(front[:, 0])
    vertices = np.concatenate([front, front + np.array([_THICKNESS, 0.0, 0.0])])
    corner = (np.arange(n - 1)[:, None] * m + np.arange(m - 1)).ravel()
    cells = np.stack([corner, corner + 1, corner + m + 1, corner + m], axis=1)
    cells = cells[there[cells].all(axis=1)]
    faces = np.concatenate([cells[:, [0, 1, 2]], cells[:, [0, 2, 3]]])
    faces = np.concatenate([faces, faces[:, ::-1] + n * m])
    used, numbering = np.unique(faces, return_inverse=True)
    return Sheet(vertices[used].round(5), numbering.reshape(-1, 3).astype(np.int32))
