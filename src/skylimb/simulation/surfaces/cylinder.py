"""Round walls: a cylinder that bulges toward the robot or is hollow, and a pipe."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.keys import Key, configuration
from skylimb.simulation.surfaces.curved import FAR, CurvedSurface
from skylimb.simulation.surfaces.geom import GEOM, Geom
from skylimb.simulation.surfaces.profile import Profile, arc, corner_arc, straight
from skylimb.simulation.surfaces.round import Round
from skylimb.simulation.surfaces.shape import Shape

_WIDEST = math.radians(85.0)  # half of the angle that a hollow cylinder may span


def round_geoms(radius: float, height: float) -> tuple[Geom, ...]:
    """The engine's own cylinder along v behind the origin, m: one to be touched, one to be looked at."""
    middle = [radius, 0.0, 0.0]
    # Longer than what is drawn, so that the tip meets its round side and never its flat end.
    touched = Geom("cylinder", [radius, height, 0.0], middle, name=GEOM, color=None)
    return touched, Geom("cylinder", [radius, 0.5 * height, 0.0], middle)


@configuration
class Cylinder(CurvedSurface):
    """A cylinder along v (`roll` turns it) that touches its flat plane at the origin.

    A hollow one spans `size` along u.
    """

    kind: Literal["cylinder"] = "cylinder"
    radius: Annotated[float, Key("m", "radius", low=0.01, high=1000.0)] = 1.0
    concave: Annotated[bool, Key("", "hollow, around the robot, instead of bulging toward it")] = False

    def check(self) -> None:
        """Refuse a hollow cylinder that would be wider than its arc."""
        super().check()
        if self.concave and 0.5 * self.size[0] > self.radius * math.sin(_WIDEST):
            widest = 2.0 * self.radius * math.sin(_WIDEST)
            raise ConfigError(
                f"surface.size: a hollow cylinder of {self.radius:g} m cannot be {self.size[0]:g} m wide: "
                f"at most {widest:.3g} m"
            )

    def make_shape(self) -> Shape:
        """A bulging one is round; a hollow one an arc whose rims go over into a flat wall."""
        if not self.concave:
            return Round(self.radius)
        half_angle = math.asin(0.5 * self.size[0] / self.radius)
        s, c = math.sin(half_angle), math.cos(half_angle)
        left, right = ((side * self.radius * s, self.radius * (c - 1.0)) for side in (-1.0, 1.0))
        return Profile(
            (
                straight((-FAR, left[1]), left),
                corner_arc(left, (1.0, 0.0), (c, s), 0.0, half_angle),
                arc((0.0, -self.radius), self.radius, half_angle, (0.0, 1.0)),
                corner_arc(right, (c, -s), (1.0, 0.0), 0.0, half_angle),
                straight(right, (FAR, right[1])),
            )
        )

    def drawn_u(self) -> np.ndarray:
        """Places from one side to the other, as far around as the surface faces the robot."""
        half = min(0.5 * self.size[0], self.radius * math.sin(_WIDEST))
        return np.linspace(-half, half, 121)

    @property
    def geoms(self) -> tuple[Geom, ...]:
        """A bulging cylinder is one of the engine's own; a hollow one goes through the collision function."""
        return super().geoms if self.concave else round_geoms(self.radius, self.size[1])


@configuration
class Pipe(Cylinder):
    """A pipe, touched from outside; along u by default, as pipes lie, with `roll` to turn it."""

    kind: Literal["pipe"] = "pipe"  # type: ignore[assignment]
    radius: float = 0.15
    roll: float = 0.5 * math.pi
