"""How tip and surface push on each other, in physical units: the keys of a contact."""

from __future__ import annotations

import math
from typing import Annotated

from skylimb.base.keys import Key, configuration

PAIR_NAME = "tip_surface"
"""Of the pair of tip and surface in the engine's model."""

TIP_GEOM = TIP_SITE = "tip"
"""Of what touches, and of the site in its middle, in the engine's model."""

Friction = Annotated[float, Key("", "Coulomb coefficient mu", low=0.0, high=10.0)]
Stiffness = Annotated[float, Key("N/m", "normal stiffness k", low=50.0, high=1e6)]
DampingRatio = Annotated[
    float,
    Key(
        "",
        "damping ratio zeta of the normal direction: c = 2 zeta sqrt(k m), m the tip's effective mass",
        low=0.0,
        high=10.0,
    ),
]
Damping = Annotated[
    float | None, Key("N s/m", "normal damping c, in place of damping_ratio", low=0.0, high=1e5)
]
Adhesion = Annotated[
    float, Key("N", "force with which the surface can pull the tip before it lets go", low=0.0, high=1e3)
]


@configuration
class ContactParameters:
    """How the tip and a surface push on each other.

    Adhesion adds to the normal force that friction acts on, but only while the contact is pressed: the
    engine has no friction under a net pull.
    """

    friction: Friction = 0.4
    stiffness: Stiffness = 5000.0
    damping_ratio: DampingRatio = 0.3
    damping: Damping = None
    stick_damping: Annotated[
        float,
        Key(
            "N s/m",
            "damping c_t of a tip that sticks: under a tangential force F_t it creeps at F_t / c_t",
            above=0.0,
            high=1e9,
        ),
    ] = 8e4
    friction_rate: Annotated[
        float,
        Key(
            "1/s",
            "rate b_f at which slip reaches the friction cone; below 200 an oblique bounce gains energy",
            above=0.0,
            high=1e6,
        ),
    ] = 200.0
    adhesion: Adhesion = 0.0

    def normal_damping(self, effective_mass: float) -> float:
        """Damping c of the normal direction, N s/m, for a tip of this effective mass (kg)."""
        if self.damping is not None:
            return self.damping
        return 2.0 * self.damping_ratio * math.sqrt(self.stiffness * effective_mass)
