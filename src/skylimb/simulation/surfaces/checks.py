"""What must hold between a surface, a robot and a path before anything flies."""

from __future__ import annotations

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.simulation.surfaces.surface import Surface


def require_fits(surface: Surface, tip_radius: float) -> None:
    """Raise a `ConfigError` when a hollow is too narrow for one touch of a tip of this radius, m."""
    tightest = surface.tightest_hollow
    if tightest < tip_radius:
        raise ConfigError(
            f"surface '{surface.kind}': its tightest hollow has a radius of {1e3 * tightest:.3g} mm, "
            f"narrower than the tip's {1e3 * tip_radius:.3g} mm: make the surface gentler, or the tip smaller"
        )


def require_clear(
    surface: Surface, points: np.ndarray, radius: float | np.ndarray = 0.0, what: str = "the robot"
) -> None:
    """Raise a `ConfigError` when the surface overlaps spheres of `radius` (m) at `points` (n, 3), W, m."""
    gaps = surface.signed_distance(np.atleast_2d(points), 0.0) - radius
    worst = int(np.argmin(gaps))
    if not gaps[worst] > 0.0:
        x, y, z = np.atleast_2d(points)[worst]
        raise ConfigError(
            f"surface '{surface.kind}' intersects {what} at the start: {-1e3 * gaps[worst]:.3g} mm deep at "
            f"({x:.3f}, {y:.3f}, {z:.3f}) m; move surface.position = {list(surface.position)} away from it"
        )


def require_path(surface: Surface, points: np.ndarray, what: str = "the path") -> None:
    """Raise a `ConfigError` when points (n, 3), W, m, do not all face the surface within its `size`."""
    points = np.atleast_2d(points)
    outside = np.flatnonzero(~surface.covers(points))
    if len(outside):
        x, y, z = points[outside[0]]
        (_, u, v), (width, height) = surface.to_local(points[outside[0]]), surface.size
        raise ConfigError(
            f"{what} leaves surface '{surface.kind}' at ({x:.3f}, {y:.3f}, {z:.3f}) m: u = {u:.3f} m, "
            f"v = {v:.3f} m are off its surface.size of {width:g} m x {height:g} m, or off its shape"
        )
