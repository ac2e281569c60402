"""Surfaces of flat faces with rounded edges: step, ridge and ramp."""

from __future__ import annotations

import abc
import math
from typing import Annotated, Literal

import numpy as np

from skylimb.base.keys import Key, configuration, refused
from skylimb.simulation.surfaces.curved import FAR, CurvedSurface
from skylimb.simulation.surfaces.profile import Profile, polyline


@configuration
class FacedSurface(CurvedSurface, abc.ABC):
    """Flat faces that meet in edges along v (`roll` turns them)."""

    offset: Annotated[
        float, Key("m", "u of the step, the ridge or the ramp's middle", low=-50.0, high=50.0)
    ] = 0.0
    edge_radius: Annotated[
        float, Key("m", "radius of bulging edges; 0 for sharp ones", low=0.0, high=10.0)
    ] = 0.002
    fillet_radius: Annotated[
        float, Key("m", "radius of hollow corners; not below the tip's radius", low=0.0, high=10.0)
    ] = 0.01

    def check(self) -> None:
        """Raise a `ConfigError` for a step beside the surface, and for faces without room."""
        super().check()
        half = 0.5 * self.size[0]
        if abs(self.offset) > half:
            raise refused(self, "offset", f"is outside of the surface, {-half:g} .. {half:g} m")
        _ = self.shape  # refuses faces that leave no room for their roundings

    @property
    @abc.abstractmethod
    def corners(self) -> list[tuple[float, float]]:
        """Corners (u, w) between the ends, m, before they are rounded."""

    def drawn_u(self) -> np.ndarray:
        """The places of the edges, so that they are drawn sharp."""
        half = 0.5 * self.size[0]
        inner = self.profile.landmarks()
        return np.concatenate([[-half], inner[np.abs(inner) < half], [half]])

    @property
    def profile(self) -> Profile:
        """The shape as a profile of pieces."""
        shape = self.shape
        assert isinstance(shape, Profile)
        return shape

    def make_shape(self) -> Profile:
        """Straight faces and round edges, with the origin on the surface."""
        inner = [(u + self.offset, w) for u, w in self.corners]
        points = [(-FAR, inner[0][1]), *inner, (FAR, inner[-1][1])]
        raw = Profile(polyline(points, self.edge_radius, self.fillet_radius))
        shift = float(raw.height(0.0, 0.0))
        points = [(u, w - shift) for u, w in points]
        return Profile(polyline(points, self.edge_radius, self.fillet_radius))


@configuration
class Step(FacedSurface):
    """A step in a flat wall: beyond `offset` toward +u the wall stands `rise` closer to the robot."""

    kind: Literal["step"] = "step"
    rise: Annotated[
        float, Key("m", "height of the step, toward the robot; negative recedes", low=-1.0, high=1.0)
    ] = 0.01
    riser_angle: Annotated[
        float, Key("rad", "angle of the riser against the wall", low=0.01, high=math.radians(89.0))
    ] = 0.25 * math.pi

    @property
    def corners(self) -> list[tuple[float, float]]:
        """Corners (u, w), m: foot and top of the riser."""
        half = 0.5 * abs(self.rise) / math.tan(self.riser_angle)
        if self.rise == 0.0:
            return [(0.0, 0.0)]
        return [(-half, 0.0), (half, -self.rise)]


@configuration
class Ridge(FacedSurface):
    """A ridge across a flat wall, like a roof's."""

    kind: Literal["ridge"] = "ridge"
    rise: Annotated[
        float,
        Key(
            "m", "height of its top over the wall, toward the robot; negative is a groove", low=-1.0, high=1.0
        ),
    ] = 0.02
    width: Annotated[float, Key("m", "width of its foot along u", low=1e-3, high=10.0)] = 0.1

    @property
    def corners(self) -> list[tuple[float, float]]:
        """Corners (u, w), m: foot, top and foot."""
        half = 0.5 * self.width
        return [(-half, 0.0), (0.0, -self.rise), (half, 0.0)]


@configuration
class Ramp(FacedSurface):
    """A ramp between two parallel planes."""

    kind: Literal["ramp"] = "ramp"
    rise: Annotated[
        float, Key("m", "by which the plane toward +u stands closer to the robot", low=-2.0, high=2.0)
    ] = 0.1
    width: Annotated[float, Key("m", "width of the ramp along u", low=1e-3, high=10.0)] = 0.4
    edge_radius: float = 0.02
    fillet_radius: float = 0.05

    @property
    def corners(self) -> list[tuple[float, float]]:
        """Corners (u, w), m: foot and top of the ramp."""
        half = 0.5 * self.width
        return [(-half, 0.0), (half, -self.rise)]
