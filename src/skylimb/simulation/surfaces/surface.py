"""What every surface is: a placed shape with friction and compliance that writes itself into the physics.

A shape is described once, in its own axes (w into the surface, u and v along it; see `placement`), by the
closest point to any given one. Everything that the analysis needs follows from that here: signed distance,
normal, projection, distance along a direction. The same numbers go into the physics, so that both see one
geometry.
"""

from __future__ import annotations

import abc
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from skylimb.base.config import to_mapping
from skylimb.base.errors import ConfigError
from skylimb.base.keys import configuration
from skylimb.simulation.contact_keys import ContactParameters
from skylimb.simulation.surfaces import motion as moving
from skylimb.simulation.surfaces.friction_map import static_excess
from skylimb.simulation.surfaces.geom import Geom, Hinge
from skylimb.simulation.surfaces.placement import surface_rotation
from skylimb.simulation.surfaces.shape import meeting
from skylimb.simulation.surfaces.surface_keys import SurfaceKeys
from skylimb.simulation.surfaces.touched import Touched


@configuration
class Surface(SurfaceKeys, Touched):
    """A surface in the world: its keys, and what follows from them and from its shape."""

    many: ClassVar[bool] = False
    """Whether it is touched in several places at once (`Hole`)."""

    path_on_plane: ClassVar[bool] = False
    """Whether a path lies on its flat plane w = 0, whatever stands out of that or lies behind it."""

    # What a kind of surface says about its shape, in its own axes. Points are (..., 3) arrays of (w, u, v).

    @abc.abstractmethod
    def local_closest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The surface point closest to each, and the outward unit normal (toward the robot) there."""

    def height(self, u: ArrayLike, v: ArrayLike) -> np.ndarray:
        """The surface's w at (u, v), m: how far it recedes from its flat plane; NaN where there is none."""
        return np.zeros(np.broadcast(u, v).shape)

    @property
    @abc.abstractmethod
    def geoms(self) -> tuple[Geom, ...]:
        """What it is in the engine's model: what is touched, called `GEOM`, and what is only looked at."""

    def unroll(self, u: ArrayLike, v: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Lengths along the surface at (u, v), m, as a ruler laid on it reads them: u and v on a flat one."""
        return np.asarray(u, dtype=float), np.asarray(v, dtype=float)

    # What follows from it.

    @property
    def contact(self) -> ContactParameters:
        """Friction and compliance as the physics takes them."""
        return ContactParameters(
            friction=self.friction,
            stiffness=self.stiffness,
            damping_ratio=self.damping_ratio,
            damping=self.damping,
            adhesion=max(self.adhesion, self.friction_map.most_adhesion if self.friction_map else 0.0),
        )

    @property
    def tightest_hollow(self) -> float:
        """Smallest radius of curvature of a hollow, m, where a tip must fit; infinite if there is none."""
        return float("inf")

    @property
    def friction_varies(self) -> bool:
        """Whether friction depends on place or speed, so that the loop must write it (`PairFriction`)."""
        return self.friction_map is not None or self.static_ratio != 1.0

    def friction_at(
        self, points: np.ndarray, slip: Any = 0.0, time: Any = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Coulomb coefficient and adhesion (N) at world points (..., 3) and slip speeds (...), m/s."""
        local = self.to_local(points, time)
        friction, adhesion = self.sliding_friction(local[..., 1], local[..., 2])
        return friction * static_excess(np.square(slip), self.static_ratio, self.static_speed), adhesion

    def sliding_friction(self, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coulomb coefficient in motion and adhesion (N) at places (...) of its flat plane, m."""
        if self.friction_map is None:
            return np.full(u.shape, self.friction), np.full(u.shape, self.adhesion)
        return self.friction_map.over((self.friction, self.adhesion), self.size, u, v)

    @property
    def moves(self) -> bool:
        """Whether the surface moves."""
        return self.advance_distance != 0.0 or self.sway_amplitude != 0.0

    def require_still(self) -> None:
        """Raise a `ConfigError` where it moves or its friction varies, for kinds that can do neither."""
        if self.moves or self.friction_varies:
            raise ConfigError(
                f"surface.kind = '{self.kind}' stays where it is and has one friction: leave out surface."
                "advance_distance, surface.sway_amplitude, surface.friction_map and surface.static_ratio"
            )

    @property
    def hinge(self) -> Hinge | None:
        """The hinge of a part of it that turns (`Valve`), or None."""
        return None

    @property
    def turns(self) -> bool:
        """Whether a part of it turns on a hinge."""
        return self.hinge is not None

    @cached_property
    def R_WS(self) -> np.ndarray:
        """(3, 3) rotation whose columns are the surface's axes w (into it), u and v in the world."""
        return surface_rotation(self.contact_axis, self.slope, self.pitch, self.roll)

    @cached_property
    def motion_axis(self) -> np.ndarray:
        """(3,) unit vector along which the surface moves, W."""
        if self.motion_direction is not None:
            return np.asarray(self.motion_direction, dtype=float)
        return -np.asarray(self.contact_axis, dtype=float)

    def motion(self, t: Any) -> tuple[np.ndarray, np.ndarray]:
        """Displacement (m) and velocity (m/s) along `motion_axis` at time `t` (s, a number or an array)."""
        t = np.asarray(t, dtype=float)
        x, v = moving.sway(t, self.sway_amplitude, self.sway_frequency)
        if self.advance_distance != 0.0:
            dx, dv = moving.advance(t, self.advance_distance, self.advance_speed, self.advance_start)
            x, v = x + dx, v + dv
        return x, v

    def velocity(self, time: Any) -> np.ndarray:
        """Velocity (..., 3) with which it moves by itself at times (...), W, m/s."""
        return self.motion(time)[1][..., None] * self.motion_axis

    def to_local(self, points: np.ndarray, time: Any = None) -> np.ndarray:
        """World points (..., 3) in the surface's axes (w, u, v); `time` (s) takes a moving surface along."""
        points = np.asarray(points, dtype=float) - np.asarray(self.position)
        if time is not None and self.moves:
            points = points - self.motion(time)[0][..., None] * self.motion_axis
        return points @ self.R_WS

    def to_world(self, local: np.ndarray, time: Any = None) -> np.ndarray:
        """Points (..., 3) in the surface's axes, in the world; the inverse of `to_local`."""
        points = np.asarray(local, dtype=float) @ self.R_WS.T + np.asarray(self.position)
        if time is not None and self.moves:
            points = points + self.motion(time)[0][..., None] * self.motion_axis
        return points

    def nearest(self, points: np.ndarray, time: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Points, closest points and outward normals there in the surface's own axes, (..., 3) each."""
        local = self.to_local(points, time)
        return local, *self.local_closest(local)

    def in_world(self, vectors: np.ndarray, time: Any) -> np.ndarray:
        """Vectors (..., 3) of the surface's own axes in those of W."""
        return vectors @ self.R_WS.T

    def project(self, points: np.ndarray, time: Any = None) -> np.ndarray:
        """The surface points (..., 3), W, closest to world points (..., 3)."""
        return self.to_world(self.local_closest(self.to_local(points, time))[0], time)

    def distance_along(self, points: np.ndarray, direction: np.ndarray | None = None) -> np.ndarray:
        """Distance (...) from world points (..., 3) to the surface along a unit `direction`, m.

        By default along the contact axis: positive ahead of the surface, negative behind it. NaN where the
        surface turns away from that direction before it is met. A path that is on the flat plane
        (`path_on_plane`) is met there.
        """
        direction = np.asarray(self.contact_axis if direction is None else direction, dtype=float)
        points = np.asarray(points, dtype=float)
        if self.path_on_plane:
            return -self.to_local(points)[..., 0] / float(self.R_WS[:, 0] @ direction)

        def local(along: np.ndarray) -> np.ndarray:
            return self.to_local(points + along[..., None] * direction)

        return meeting(self.local_closest, local, self.R_WS.T @ direction, points.shape[:-1])

    def covers(self, points: np.ndarray) -> np.ndarray:
        """Whether world points (..., 3) face the surface within its `size`."""
        local = self.to_local(points)
        half_u, half_v = 0.5 * self.size[0], 0.5 * self.size[1]
        inside = (np.abs(local[..., 1]) <= half_u) & (np.abs(local[..., 2]) <= half_v)
        return inside & np.isfinite(self.height(local[..., 1], local[..., 2]))

    def describe(self) -> dict[str, Any]:
        """The surface in plain values for a record: enough to draw it and to unroll a trace on it.

        Keys: kind, origin, axis_u, axis_v, normal (the flat plane's, outward), size, parameters (every
        field), and for a
        curved one `u`, `v` (grids, m), `height` (len(u) x len(v), m along -normal) and `unrolled_u` (length
        along the surface at each u with v = 0).
        """
        w, u, v = self.R_WS.T
        return {
            "kind": self.kind,
            "origin": list(map(float, self.position)),
            "axis_u": u.tolist(),
            "axis_v": v.tolist(),
            "normal": (-w).tolist(),
            "size": list(map(float, self.size)),
            "parameters": to_mapping(self),
        }
