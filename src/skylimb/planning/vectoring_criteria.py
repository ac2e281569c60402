"""What vectoring angles are chosen for."""

from __future__ import annotations

import math
from dataclasses import dataclass

from skylimb.planning.posture import posture_family
from skylimb.robots import Robot


@dataclass(frozen=True)
class VectoringCriteria:
    """What the search for psi(theta) maximises and what it must keep.

    Attributes:
        purpose: short name, in the name of the file.
        degree: of each joint's polynomial.
        smoothing: guaranteed torque given up for a smoother path, N m per (rad/rad)^2.
        slope: greatest |dpsi/dtheta| at the nodes, rad/rad.
        tilt: greatest hover tilt at the nodes, in roll and in pitch, rad.
        thrust_margin: share of each rotor's range of thrusts that hover keeps from both ends.
        leak: greatest |X_xy| and |X_xz| of `tip_force_map`: a push across the surface into the pressing
            force.
        sideways: least X_yy of `tip_force_map`.
        reachable: search the part of the family of postures within the joint limits, not all that is
            described.
    """

    purpose: str
    degree: int = 7
    smoothing: float = 0.03
    slope: float = 1.95
    tilt: float = 5e-4
    thrust_margin: float = 0.0
    leak: float = math.inf
    sideways: float = -math.inf
    reachable: bool = False

    @property
    def about_contact(self) -> bool:
        """Whether the tip counts."""
        return math.isfinite(self.leak) or math.isfinite(self.sideways)

    @property
    def kept(self) -> str:
        """What a path keeps, in words, for messages."""
        if not self.about_contact:
            return "hover without tilt"
        return (
            f"hover with at most {self.tilt:g} rad of tilt and let at most {self.leak:g} N leak into the "
            "pressing force for each newton across"
        )

    def span(self, robot: Robot) -> tuple[float, float]:
        """The range of theta that is searched, rad."""
        posture = robot.description.posture
        if not self.reachable:
            return posture.theta_min, posture.theta_max
        family = posture_family(robot)
        return family.theta_min, family.theta_max


TORQUE = VectoringCriteria("torque")
"""Most guaranteed torque, no hover tilt: the paper's own choice."""

CONTACT = VectoringCriteria("contact", tilt=0.05, thrust_margin=0.15, leak=0.1, sideways=0.0, reachable=True)
"""Most guaranteed torque among those that hardly leak a push across the surface into the pressing force."""
