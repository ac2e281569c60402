"""Friction and stickiness that vary over a surface, and friction that falls when the tip starts to slide.

The engine has one friction coefficient for a pair, so the loop writes it anew, at the place where the tip
is: once a control tick is exact to the distance that the tip travels in one.
"""

from __future__ import annotations

from dataclasses import field
from functools import cached_property
from typing import Annotated, Any

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.keys import Key, configuration
from skylimb.base.sources import Source
from skylimb.simulation.contact_keys import Adhesion, Friction
from skylimb.simulation.surfaces.tables import checked_rows, on_grid, read_table, values_in
from skylimb.symbolic import exp


@configuration
class Patch:
    """A rectangle or a disc with a friction of its own."""

    center: Annotated[tuple[float, float], Key("m", "its middle (u, v)", low=-100.0, high=100.0)] = (0.0, 0.0)
    size: Annotated[
        tuple[float, float], Key("m", "sides of a rectangle, along u and v", above=0.0, high=100.0)
    ] = (
        0.1,
        0.1,
    )
    radius: Annotated[float | None, Key("m", "radius of a disc, in place of size", above=0.0, high=100.0)] = (
        None
    )
    friction: Friction = 0.4
    adhesion: Adhesion = 0.0

    def distance(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Distance from the patch's border, m; negative inside."""
        x, y = np.abs(u - self.center[0]), np.abs(v - self.center[1])
        if self.radius is not None:
            return np.hypot(x, y) - self.radius
        x, y = x - 0.5 * self.size[0], y - 0.5 * self.size[1]
        return np.hypot(np.maximum(x, 0.0), np.maximum(y, 0.0)) + np.minimum(np.maximum(x, y), 0.0)


@configuration
class FrictionMap:
    """How friction varies over (u, v); where it says nothing, the surface's own friction holds.

    Patches have names; later ones lie over earlier ones.
    """

    patches: dict[str, Patch] = field(default_factory=dict)
    blend: Annotated[
        float,
        Key("m", "width over which a patch's border passes from outside to inside", above=0.0, high=10.0),
    ] = 0.002
    table: Annotated[
        tuple[tuple[float, ...], ...],
        Key(
            "",
            "rows of coefficients over the surface's size, bilinear between them; first row on top, first "
            "column on the viewer's left",
            low=0.0,
            high=10.0,
        ),
    ] = ()
    file: Annotated[str, Key("", "an image or numbers, in place of table", file=True)] = ""
    low: Annotated[float, Key("", "coefficient of the value 0 in file", low=0.0, high=10.0)] = 0.0
    high: Annotated[float, Key("", "coefficient of the value 1 in file", low=0.0, high=10.0)] = 1.0

    def check(self) -> None:
        """Raise a `ConfigError` for coefficients below zero, and for two sources at once."""
        if self.table and self.file:
            raise ConfigError("surface.friction_map: give a table or a file, not both")
        values = self.values()
        if values is not None and not np.all(values >= 0.0):
            row, column = np.argwhere(~(values >= 0.0))[0]
            raise ConfigError(
                f"surface.friction_map: the coefficient {values[row, column]:g} in row {row + 1}, "
                f"column {column + 1} must be a number, 0 or more"
            )

    @property
    def most_adhesion(self) -> float:
        """The largest adhesion of a patch, N."""
        return max((patch.adhesion for patch in self.patches.values()), default=0.0)

    @cached_property
    def sources(self) -> tuple[Source, ...]:
        """The file as it was read, where there is one."""
        return (read_table(self.file, f"friction map '{self.file}'"),) if self.file else ()

    def values(self) -> np.ndarray | None:
        """The coefficients of the table or file, rows and columns as given; None without one."""
        if self.file:
            relative = values_in(self.sources[0], f"friction map '{self.file}'")
            return self.low + (self.high - self.low) * relative
        if not self.table:
            return None
        return checked_rows(self.table, "surface.friction_map.table")

    def over(
        self, base: tuple[float, float], size: tuple[float, float], u: np.ndarray, v: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Friction and adhesion (N) at (u, v), m, on a surface with its own two and this size."""
        values = self.values()
        friction, adhesion = np.full(u.shape, base[0]), np.full(u.shape, base[1])
        if values is not None:
            friction = _bilinear(on_grid(values), u / size[0] + 0.5, v / size[1] + 0.5)
        for patch in self.patches.values():
            inside = np.clip(0.5 - patch.distance(u, v) / self.blend, 0.0, 1.0)
            friction = friction + inside * (patch.friction - friction)
            adhesion = adhesion + inside * (patch.adhesion - adhesion)
        return friction, adhesion


def _bilinear(grid: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    n, m = grid.shape
    x, y = np.clip(x, 0.0, 1.0) * (n - 1), np.clip(y, 0.0, 1.0) * (m - 1)
    i, j = np.minimum(x.astype(int), max(n - 2, 0)), np.minimum(y.astype(int), max(m - 2, 0))
    p, q = x - i, y - j
    i1, j1 = np.minimum(i + 1, n - 1), np.minimum(j + 1, m - 1)
    top = grid[i, j] * (1 - q) + grid[i, j1] * q
    return top * (1 - p) + (grid[i1, j] * (1 - q) + grid[i1, j1] * q) * p


def static_excess(slip_squared: Any, ratio: Any, speed: Any) -> Any:
    """Factor (...) on the kinetic coefficient at a slip speed: `ratio` at rest, 1 far above `speed` (m/s).

    It falls as a Gaussian, Stribeck's curve without its viscous part. The slip speed is given squared.
    """
    return 1.0 + (ratio - 1.0) * exp(-slip_squared / speed**2)
