"""What vectoring angles are chosen for."""

from __future__ import annotations

import math
from typing import Annotated

from skylimb.base.keys import Key, configuration
from skylimb.control.planning import posture
from skylimb.robots import Robot


@configuration
class VectoringCriteria:
    """What the search for psi(theta) keeps while it maximises the guaranteed control torque.

    All of it holds at the nodes of the search, and between them to a per cent or so.
    """

    purpose: Annotated[str, Key("", "short name, in the name of the file")]
    degree: Annotated[int, Key("", "degree of each joint's polynomial", low=3, high=15)] = 7
    smoothing: Annotated[
        float,
        Key("N m", "guaranteed torque given up for a path smoother by 1 (rad/rad)^2", low=0.0, high=100.0),
    ] = 0.03
    slope: Annotated[float, Key("rad/rad", "greatest |dpsi/dtheta|", above=0.0, high=100.0)] = 1.95
    tilt: Annotated[
        float,
        Key(
            "rad",
            "greatest hover tilt, in roll and in pitch; where the tip counts, in both together",
            low=1e-6,
            high=0.5,
        ),
    ] = 5e-4
    thrust_margin: Annotated[
        float,
        Key(
            "",
            "share of each rotor's range of thrusts that hover keeps from both of its ends",
            low=0.0,
            high=0.45,
        ),
    ] = 0.0
    leak: Annotated[
        float,
        Key(
            "",
            "greatest |X_xy| and |X_xz| of `tip_force_map`, what a push across the surface adds to the "
            "pressing force; inf where it does not count",
            above=0.0,
            high=math.inf,
            finite=False,
        ),
    ] = math.inf
    sideways: Annotated[
        float,
        Key(
            "",
            "least X_yy of `tip_force_map`; -inf where it does not count",
            low=-math.inf,
            below=math.inf,
            finite=False,
        ),
    ] = -math.inf
    effort: Annotated[
        float,
        Key(
            "rad/N",
            "greatest `lateral_effort`; inf where it does not count. It makes the search four times as long",
            above=0.0,
            high=math.inf,
            finite=False,
        ),
    ] = math.inf
    servos: Annotated[
        float,
        Key(
            "",
            "share of each bending joint's servo that hover may take; inf where it does not count",
            above=0.0,
            high=math.inf,
            finite=False,
        ),
    ] = math.inf
    reachable: Annotated[
        bool, Key("", "whether to search the postures within the joint limits, not all that are described")
    ] = False

    @property
    def about_contact(self) -> bool:
        """Whether the tip counts."""
        return any(map(math.isfinite, (self.leak, self.sideways, self.effort)))

    @property
    def kept(self) -> str:
        """What a path keeps, in words, for messages."""
        if not self.about_contact:
            return "hover without tilt"
        return (
            f"hover with at most {self.tilt:g} rad of tilt and keep the pushes across the surface out of the "
            f"pressing force (leak at most {self.leak:g}, X_yy at least {self.sideways:g})"
        )

    def span(self, robot: Robot) -> tuple[float, float]:
        """The range of theta that is searched, rad."""
        described = robot.description.posture
        if not self.reachable:
            return described.theta_min, described.theta_max
        family = posture.posture_family(robot)
        return family.theta_min, family.theta_max


TORQUE = VectoringCriteria("torque")
"""Most guaranteed torque without hover tilt, over all described postures."""

CONTACT = VectoringCriteria(
    posture.CONTACT, tilt=0.1, effort=0.5, thrust_margin=0.15, leak=0.1, sideways=0.0, reachable=True
)
"""Most guaranteed torque where a push across the surface hardly reaches the pressing force.

For hydrus_xi_quad the search finds no continuous path with 0.04 rad of tilt, nor with a leak of 0.05. With
0.05 rad the lateral effort is up to 1.6 rad/N, with 0.1 rad 0.5 rad/N.
"""
