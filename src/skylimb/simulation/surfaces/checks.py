"""What must hold between a surface, a robot and a path before anything flies."""

from __future__ import annotations

import math

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.simulation.surfaces.surface import Surface

_FARTHEST = 3.0
"""Way over which a clear place is sought, m."""
_NEAR = 1e-4
"""How exactly it is found, m."""
_ROOM = 0.03
"""Gap at the place that a message proposes, m: servos that give way move a tip by a centimetre or two."""


def require_fits(surface: Surface, tip_radius: float) -> None:
    """Raise a `ConfigError` when a hollow is too narrow for one touch of a tip of this radius, m."""
    tightest = surface.tightest_hollow
    if tightest < tip_radius:
        raise ConfigError(
            f"surface '{surface.kind}': its tightest hollow has a radius of {1e3 * tightest:.3g} mm, "
            f"narrower than the tip's {1e3 * tip_radius:.3g} mm: make the surface gentler, or the tip smaller"
        )


def require_clear(
    surface: Surface,
    points: np.ndarray,
    radius: float | np.ndarray = 0.0,
    what: str = "the robot",
    axis: np.ndarray | None = None,
) -> None:
    """Raise a `ConfigError` when the surface overlaps spheres of `radius` (m) at `points` (n, 3), W, m.

    Args:
        surface: to be clear of.
        points: centres of the spheres.
        radius: of them.
        what: they are called in the message.
        axis: unit vector against which the approach's standoff moves them; by default the contact axis.
    """
    points = np.atleast_2d(points)
    gaps = surface.signed_distance(points, 0.0) - radius
    worst = int(np.argmin(gaps))
    if not gaps[worst] > 0.0:
        (x, y, z), way = points[worst], way_clear(surface, points, radius, axis, _ROOM)
        remedy = "no larger one is clear"
        if way < np.inf:
            remedy = f"with {math.ceil(1e3 * way) / 1e3:g} m more of it the robot starts clear"
        raise ConfigError(
            f"surface '{surface.kind}' intersects {what} at the start: {-1e3 * gaps[worst]:.3g} mm deep at "
            f"({x:.3f}, {y:.3f}, {z:.3f}) m; approach.standoff is too small: {remedy}"
        )


def way_clear(
    surface: Surface,
    points: np.ndarray,
    radius: float | np.ndarray = 0.0,
    axis: np.ndarray | None = None,
    keep: float = 0.0,
) -> float:
    """How far spheres must move against a unit `axis` until they are clear of the surface, m.

    Args:
        surface: to be clear of.
        points: centres of the spheres, (n, 3), W, m.
        radius: of them, m.
        axis: by default the contact axis.
        keep: gap that they are to have then, m.

    Returns:
        Infinity where no way within some metres leads out.
    """
    axis = np.asarray(surface.contact_axis if axis is None else axis, dtype=float)
    way = 0.0
    while way < _FARTHEST:
        gap = float(np.min(surface.signed_distance(points - way * axis, 0.0) - radius))
        # No step goes too far: over a way, the distance changes by no more than the way.
        if gap > keep:
            return way
        way += max(keep - gap, _NEAR)
    return np.inf


def require_path(surface: Surface, points: np.ndarray) -> None:
    """Raise a `ConfigError` when points (n, 3), W, m, do not all face the surface within its `size`."""
    points = np.atleast_2d(points)
    outside = np.flatnonzero(~surface.covers(points))
    if len(outside):
        x, y, z = points[outside[0]]
        (_, u, v), (width, height) = surface.to_local(points[outside[0]]), surface.size
        raise ConfigError(
            f"the path leaves surface '{surface.kind}' at ({x:.3f}, {y:.3f}, {z:.3f}) m: u = {u:.3f} m, "
            f"v = {v:.3f} m are off its surface.size of {width:g} m x {height:g} m, or off its shape"
        )
