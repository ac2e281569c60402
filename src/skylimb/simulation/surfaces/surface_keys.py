"""The keys that all kinds of surface share."""

from __future__ import annotations

from typing import Annotated

from skylimb.base.keys import Key, configuration
from skylimb.simulation.contact_keys import Adhesion, Damping, DampingRatio, Friction, Stiffness
from skylimb.simulation.surfaces.friction_map import FrictionMap
from skylimb.simulation.surfaces.placement import check_unit_vector

_Vector = tuple[float, float, float]


@configuration
class SurfaceKeys:
    """What is touched, and how it stands, gives way and moves."""

    kind: Annotated[str, Key("", "kind of surface, or a Python file of your own")] = ""
    position: Annotated[
        _Vector, Key("m", "a point of it in W: the shape's own origin (u = v = 0)", low=-100.0, high=100.0)
    ] = (1.0, 0.0, 1.0)
    contact_axis: Annotated[
        _Vector,
        Key(
            "",
            "unit vector in W from the robot into the surface, before slope and pitch",
            low=-1.001,
            high=1.001,
        ),
    ] = (1.0, 0.0, 0.0)
    slope: Annotated[
        float, Key("rad", "turn about its v axis; positive recedes toward +u", low=-1.4, high=1.4)
    ] = 0.0
    pitch: Annotated[
        float, Key("rad", "turn about its u axis; positive recedes toward +v", low=-1.4, high=1.4)
    ] = 0.0
    roll: Annotated[float, Key("rad", "turn of the shape in its own plane", low=-3.2, high=3.2)] = 0.0
    size: Annotated[
        tuple[float, float],
        Key(
            "m",
            "extent along u and v: what is drawn, and where a path may go; the contact may go on beyond it",
            low=0.01,
            high=100.0,
        ),
    ] = (2.0, 2.0)
    friction: Friction = 0.4
    friction_map: FrictionMap | None = None
    static_ratio: Annotated[
        float, Key("", "friction at rest over friction in motion (stick-slip)", low=1.0, high=10.0)
    ] = 1.0
    static_speed: Annotated[
        float,
        Key("m/s", "slip speed over which friction falls from the one to the other", low=1e-4, high=1.0),
    ] = 0.005
    stiffness: Stiffness = 5000.0
    damping_ratio: DampingRatio = 0.3
    damping: Damping = None
    adhesion: Adhesion = 0.0
    advance_distance: Annotated[
        float,
        Key("m", "how far it moves along motion_direction; 0 for a surface at rest", low=-10.0, high=10.0),
    ] = 0.0
    advance_speed: Annotated[float, Key("m/s", "speed of that move", above=0.0, high=10.0)] = 0.02
    advance_start: Annotated[float, Key("s", "time at which that move begins", low=-1e6, high=1e6)] = 0.0
    sway_amplitude: Annotated[
        float, Key("m", "amplitude of a sine along motion_direction", low=0.0, high=1.0)
    ] = 0.0
    sway_frequency: Annotated[float, Key("Hz", "frequency of that sine", low=0.0, high=50.0)] = 0.5
    motion_direction: Annotated[
        _Vector | None,
        Key(
            "",
            "unit vector in W along which it moves; by default against the contact axis, onto the robot",
            low=-1.001,
            high=1.001,
        ),
    ] = None

    def check(self) -> None:
        """Refuse directions that are no unit vectors."""
        check_unit_vector(self, "contact_axis")
        if self.motion_direction is not None:
            check_unit_vector(self, "motion_direction")
