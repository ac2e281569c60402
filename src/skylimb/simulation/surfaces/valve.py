"""A valve on a wall: a lever on a hinge with dry friction, which the tip pushes around between two stops."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, ClassVar, Literal

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.keys import Key, configuration
from skylimb.base.rotations import rot_x
from skylimb.simulation.surfaces.box import closest_on_box
from skylimb.simulation.surfaces.geom import GEOM, Geom, Hinge
from skylimb.simulation.surfaces.surface import Surface

_HALF_DEPTH = 0.06  # m, of the lever along w: a tip that is some centimetres off still meets it
_HUB = 0.04  # m, radius
_METAL = (0.72, 0.16, 0.14, 1.0)


@configuration
class Valve(Surface):
    """A lever that turns about w through `position`; its flat plane w = 0 is where the tip's front goes.

    The engine turns it: an inertia, a damper and dry friction about a hinge with two stops. It is balanced.
    `angle` 0 of the hinge is the first stop, where the lever points from the hinge along `lever_angle`.
    """

    path_on_plane: ClassVar[bool] = True
    kind: Literal["valve"] = "valve"
    lever_angle: Annotated[
        float, Key("rad", "direction of the lever at its first stop, from u toward v", low=-6.3, high=6.3)
    ] = 0.0
    travel: Annotated[float, Key("rad", "turn from the first stop to the second", above=0.0, high=6.3)] = (
        np.pi / 2
    )
    inner: Annotated[float, Key("m", "where the lever begins, from the hinge", low=0.0, high=5.0)] = 0.05
    outer: Annotated[float, Key("m", "where the lever ends, from the hinge", above=0.0, high=5.0)] = 0.35
    thickness: Annotated[float, Key("m", "of the lever, in the plane it turns in", 0.002, 0.5)] = 0.03
    friction_torque: Annotated[float, Key("N m", "dry friction of the hinge", low=0.0, high=100.0)] = 0.3
    hinge_damping: Annotated[float, Key("N m s/rad", "damper of the hinge", low=0.0, high=100.0)] = 0.05
    lever_mass: Annotated[float, Key("kg", "mass of the lever", above=0.01, high=100.0)] = 0.5

    def check(self) -> None:
        """Refuse a lever without length, and a valve that moves or whose friction varies."""
        super().check()
        self.require_still()
        if self.outer <= self.inner:
            raise ConfigError(
                f"surface.outer = {self.outer:g} m must be greater than surface.inner = {self.inner:g} m"
            )

    @cached_property
    def inertia(self) -> float:
        """Of the lever about its hinge, kg m^2."""
        length, middle = self.outer - self.inner, 0.5 * (self.outer + self.inner)
        return self.lever_mass * (length**2 / 12.0 + middle**2)

    @property
    def _half(self) -> np.ndarray:
        return np.array([_HALF_DEPTH, 0.5 * (self.outer - self.inner), 0.5 * self.thickness])

    def local_closest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """On the lever at its first stop; inside of it the nearest face counts."""
        # Axes of the lever: w, along it from its middle, across it.
        axes = rot_x(self.lever_angle)
        middle = np.array([0.0, 0.5 * (self.inner + self.outer), 0.0])
        foot, normal, _ = closest_on_box(np.asarray(points, dtype=float) @ axes - middle, self._half)
        return (foot + middle) @ axes.T, normal @ axes.T

    @property
    def geoms(self) -> tuple[Geom, ...]:
        """A lever on a hinge, a hub and the two stops."""
        middle, wall = [0.0, 0.5 * (self.inner + self.outer), 0.0], [0.01, *(0.5 * np.array(self.size))]
        across = [np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0]
        lever = Geom("box", self._half, middle, name=GEOM, color=_METAL, turns=True)
        hub = Geom("cylinder", [_HUB, _HALF_DEPTH, 0.0], quaternion=across)
        # The stops stand a little behind both ends of the way, on the wall.
        past = self.lever_angle + np.array([-1.0, 1.0]) * 0.7 * self.thickness / self.inner_or_hub
        stops = [
            Geom(
                "box",
                [_HALF_DEPTH, 0.006, 0.006],
                [0.01, *(self.inner_or_hub * np.array([np.cos(angle), np.sin(angle)]))],
            )
            for angle in past + np.array([0.0, self.travel])
        ]
        return lever, hub, Geom("box", wall, [_HALF_DEPTH + 0.02, 0.0, 0.0]), *stops

    @property
    def hinge(self) -> Hinge:
        """The lever's."""
        c, s = np.cos(0.5 * self.lever_angle), np.sin(0.5 * self.lever_angle)
        return Hinge(
            [c, s, 0.0, 0.0],
            self.travel,
            self.hinge_damping,
            self.friction_torque,
            self.lever_mass,
            self.inertia,
        )

    @property
    def inner_or_hub(self) -> float:
        """Where the stops are drawn, m from the hinge."""
        return max(self.inner, _HUB) + 0.02
