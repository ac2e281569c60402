"""Gusts: wind that pushes the robot by its drag.

    f = 1/2 rho (Cd A) |w| w

acts at the centre of gravity, with the wind w, the density rho of air at sea level,
and the robot's drag area Cd A. A gust rises and falls as one minus a cosine, the discrete gust of
MIL-F-8785C. The robot's own speed, some tenths of a metre a second, is left out beside the wind's.
The rotors' own drag (`plant.rotor_drag`) is that of air at rest. The drag
area that stands here is that of four tubes of 0.6 m by 30 mm across the wind, each with the 1.2 of a long
cylinder (Hoerner, Fluid-Dynamic Drag, 1965).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from typing import Annotated, ClassVar, Literal

import numpy as np

from skylimb.base.keys import Key, Vector3, configuration, refused
from skylimb.flight.events.event import Event, EventContext
from skylimb.flight.events.push import STRONGEST, Push, Wrench
from skylimb.robots.description import AIR_DENSITY

_STEPS = 100
"""Parts of a gust, in each of which its force is held."""


@configuration
class Wind(Event):
    """The wind blows for a while."""

    kind: Literal["wind"] = field(default="wind", kw_only=True)
    velocity: Annotated[Vector3, Key("m/s", "of the air in W, at its greatest", low=-60.0, high=60.0)]
    profile: Annotated[
        Literal["gust", "steady"], Key("", "'gust' rises and falls, 'steady' blows alike all the time")
    ] = "gust"
    drag_area: Annotated[
        float, Key("m^2", "drag coefficient times the area across the wind", above=0.0, high=10.0)
    ] = 0.086
    duration: Annotated[float, Key("s", "how long it blows", above=0.0, high=1e5)] = field(kw_only=True)

    on: ClassVar[Literal["controller", "plant"]] = "plant"
    lasts: ClassVar[bool] = True

    def check(self) -> None:
        """Refuse wind that pushes harder than a push may."""
        super().check()
        force = float(np.linalg.norm(self.force))
        if force > STRONGEST:
            raise refused(self, "velocity", f"pushes with {force:.3g} N, at most {STRONGEST:g} N")

    @property
    def force(self) -> np.ndarray:
        """Its greatest force, W, (3,) N."""
        wind = np.array(self.velocity)
        return 0.5 * AIR_DENSITY * self.drag_area * np.linalg.norm(wind) * wind

    @property
    def words(self) -> str:
        """How fast, and how hard that pushes."""
        speed, force = np.linalg.norm(self.velocity), np.linalg.norm(self.force)
        return f"wind of {speed:.3g} m/s, {force:.3g} N"

    def require(self, context: EventContext) -> None:
        """Wind blows on every robot."""

    @classmethod
    def effect(cls, events: Sequence[Wind], context: EventContext, times: np.ndarray) -> tuple[Wrench, ...]:
        """The pushes that it amounts to."""
        return Push.effect([push for wind in events for push in wind.pushes()], context, times)

    def pushes(self) -> list[Push]:
        """The wind as pushes, one behind the other."""
        parts = _STEPS if self.profile == "gust" else 1
        middles = (np.arange(parts) + 0.5) / parts
        share = np.sin(np.pi * middles) ** 4 if parts > 1 else np.ones(1)  # force goes with the speed squared
        length = self.duration / parts
        return [
            Push(self.time + number * length, duration=length, force=tuple(part * self.force))
            for number, part in enumerate(share)
        ]
