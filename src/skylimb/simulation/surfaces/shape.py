"""What a curved shape answers. Axes: w into the surface, u and v along it; the robot is at smaller w.

The closest point of a shape is written once. That of a round one (`Round`) is a line of NumPy, as the engine
has spheres and cylinders of its own. All others are C, written by hand or made from symbols, which the
engine's collision and the analysis call alike (`NativeShape`).
"""

from __future__ import annotations

import abc
from collections.abc import Callable
from functools import cached_property

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from skylimb.base.c_code import c_source
from skylimb.simulation.surfaces.collision import Kind, kind_of


class Shape(abc.ABC):
    """A curved surface in its own axes."""

    @abc.abstractmethod
    def closest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The surface points closest to points (..., 3) of (w, u, v), and the outward unit normals there."""

    @abc.abstractmethod
    def height(self, u: ArrayLike, v: ArrayLike) -> np.ndarray:
        """The surface's w (m) at (u, v); NaN where there is none."""

    @abc.abstractmethod
    def unrolled(self, u: ArrayLike) -> np.ndarray:
        """Length along the surface, m, from u = 0 to each u at v = 0."""

    @property
    def tightest_hollow(self) -> float:
        """Smallest radius of curvature of a hollow, m, where a tip must fit; infinite if there is none."""
        return float("inf")


class NativeShape(Shape):
    """A shape whose closest point is machine code."""

    @property
    @abc.abstractmethod
    def numbers(self) -> np.ndarray:
        """What the machine code is handed of this shape."""

    @property
    @abc.abstractmethod
    def source(self) -> str:
        """C that finds closest points of all shapes of this kind, as `collision.c` asks for it."""

    @cached_property
    def native(self) -> Kind:
        """The kind as machine code."""
        return kind_of(self.source)

    def closest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """By the function that the engine's collision calls."""
        return self.native.closest(self.numbers, points)


def meeting(
    closest: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]],
    ray: Callable[[np.ndarray], np.ndarray],
    direction: np.ndarray,
    shape: tuple[int, ...],
) -> np.ndarray:
    """How far along rays a surface is met, m; NaN where it turns away before it is met.

    Args:
        closest: the surface's closest points and normals.
        ray: the points (*shape, 3) of (w, u, v) that are so far along, m, (*shape).
        direction: of all rays, a unit vector along (w, u, v).
        shape: of the rays.
    """
    along, gap = np.zeros(shape), np.array(np.nan)
    for _ in range(60):
        local = ray(along)
        foot, normal = closest(local)
        gap = np.sum((local - foot) * normal, axis=-1)
        # Newton's step, held to the gap's own size where the surface is nearly parallel to the direction.
        step = gap / np.maximum(-normal @ direction, 0.2)
        along = along + step
        if np.all(np.abs(step) < 1e-12):
            break
    return np.where(np.abs(gap) < 1e-9, along, np.nan)


def c_of_touch(touch: ca.Function) -> str:
    """C of a shape given in symbols.

    Args:
        touch: of numbers (n,) and a point (3,), called "shape"; it gives the outward normal at the closest
            point and the signed distance from it, (4,). A distance of 1e9 says that there is no such point.
    """
    return f"""{c_source(touch)}
{_fits(touch)}
static int touch(
    const mjtNum* numbers, const mjtNum p[3], mjtNum reach, mjtNum normal[3], mjtNum* distance) {{
  mjtNum found[4];
  const mjtNum* given[] = {{numbers, p}};
  mjtNum* results[] = {{found}};
  shape(given, results, 0, 0, 0);
  for (int i = 0; i < 3; i++) normal[i] = found[i];
  *distance = found[3];
  (void)reach;
  return found[3] < 1e9;
}}
"""


def c_of_heights(heights: ca.Function) -> str:
    """C of a graph's heights given in symbols, for `graph.c`.

    Args:
        heights: of numbers (n,), u and v, called "shape"; it gives h, h_u, h_v, h_uu, h_uv, h_vv, (6,).
    """
    return f"""{c_source(heights)}
{_fits(heights)}
static void heights(const mjtNum* numbers, mjtNum u, mjtNum v, mjtNum h[6]) {{
  const mjtNum* given[] = {{numbers, &u, &v}};
  mjtNum* results[] = {{h}};
  shape(given, results, 0, 0, 0);
}}
"""


def _fits(function: ca.Function) -> str:
    count = function.numel_in(0)
    return f"static int fits(const mjtNum* numbers, int count) {{ (void)numbers; return count == {count}; }}"
