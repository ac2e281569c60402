"""Surfaces of flat faces with rounded edges: step, ridge and ramp."""

from __future__ import annotations

import abc
import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from skylimb.config import require_range
from skylimb.simulation.surfaces.curved import FAR, CurvedSurface
from skylimb.simulation.surfaces.profile import Profile, polyline


@dataclass(frozen=True)
class FacedSurface(CurvedSurface, abc.ABC):
    """Flat faces that meet in edges along v (`roll` turns them).

    Attributes:
        offset: u of the step, the ridge or the ramp's middle, m.
        edge_radius: of bulging edges, m; 0 for sharp ones.
        fillet_radius: of hollow corners, m; it must not be below the tip's radius.
    """

    offset: float = 0.0
    edge_radius: float = 0.002
    fillet_radius: float = 0.01

    def __post_init__(self) -> None:
        super().__post_init__()
        half = 0.5 * self.size[0]
        require_range("surface", "offset", self.offset, -half, half, "m")
        require_range("surface", "edge_radius", self.edge_radius, 0.0, 10.0, "m")
        require_range("surface", "fillet_radius", self.fillet_radius, 0.0, 10.0, "m")
        _ = self.shape  # refuses faces that leave no room for their roundings

    @property
    @abc.abstractmethod
    def corners(self) -> list[tuple[float, float]]:
        """Corners (u, w) between the ends, m, before they are rounded."""

    def drawn_u(self) -> np.ndarray:
        """Through every edge."""
        half = 0.5 * self.size[0]
        inner = self.profile.landmarks()
        return np.concatenate([[-half], inner[np.abs(inner) < half], [half]])

    @property
    def profile(self) -> Profile:
        """The shape, as what it is."""
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


@dataclass(frozen=True)
class Step(FacedSurface):
    """A step in a flat wall: beyond `offset` toward +u the wall stands `rise` closer to the robot.

    Attributes:
        rise: m; negative recedes instead.
        riser_angle: of the riser against the wall, rad.
    """

    kind: Literal["step"] = "step"
    rise: float = 0.01
    riser_angle: float = 0.25 * math.pi

    def __post_init__(self) -> None:
        require_range("surface", "rise", self.rise, -1.0, 1.0, "m")
        require_range("surface", "riser_angle", self.riser_angle, 0.01, math.radians(89.0), "rad")
        super().__post_init__()

    @property
    def corners(self) -> list[tuple[float, float]]:
        """Foot and top of the riser."""
        half = 0.5 * abs(self.rise) / math.tan(self.riser_angle)
        if self.rise == 0.0:
            return [(0.0, 0.0)]
        return [(-half, 0.0), (half, -self.rise)]


@dataclass(frozen=True)
class Ridge(FacedSurface):
    """A ridge across a flat wall, like a roof's.

    Attributes:
        rise: of its top over the wall, toward the robot, m; negative is a groove.
        width: of its foot along u, m.
    """

    kind: Literal["ridge"] = "ridge"
    rise: float = 0.02
    width: float = 0.1

    def __post_init__(self) -> None:
        require_range("surface", "rise", self.rise, -1.0, 1.0, "m")
        require_range("surface", "width", self.width, 1e-3, 10.0, "m")
        super().__post_init__()

    @property
    def corners(self) -> list[tuple[float, float]]:
        """Foot, top, foot."""
        half = 0.5 * self.width
        return [(-half, 0.0), (0.0, -self.rise), (half, 0.0)]


@dataclass(frozen=True)
class Ramp(FacedSurface):
    """A ramp between two parallel planes.

    Attributes:
        rise: by which the plane toward +u stands closer to the robot, m.
        width: of the ramp along u, m.
    """

    kind: Literal["ramp"] = "ramp"
    rise: float = 0.1
    width: float = 0.4
    edge_radius: float = 0.02
    fillet_radius: float = 0.05

    def __post_init__(self) -> None:
        require_range("surface", "rise", self.rise, -2.0, 2.0, "m")
        require_range("surface", "width", self.width, 1e-3, 10.0, "m")
        super().__post_init__()

    @property
    def corners(self) -> list[tuple[float, float]]:
        """Foot and top."""
        half = 0.5 * self.width
        return [(-half, 0.0), (half, -self.rise)]
