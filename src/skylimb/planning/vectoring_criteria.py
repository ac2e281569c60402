"""What vectoring angles are chosen for."""

from __future__ import annotations

import math
from dataclasses import dataclass

from skylimb.config import require_non_negative, require_positive, require_range
from skylimb.errors import ConfigError
from skylimb.planning.posture import posture_family
from skylimb.robots import Robot


@dataclass(frozen=True)
class VectoringCriteria:
    """What the search for psi(theta) keeps while it maximises the guaranteed control torque.

    All of it holds at the nodes of the search, and between them to a per cent or so.

    Attributes:
        purpose: short name, in the name of the file.
        degree: of each joint's polynomial, at least 3.
        smoothing: guaranteed torque given up for a smoother path, N m per (rad/rad)^2.
        slope: greatest |dpsi/dtheta|, rad/rad.
        tilt: greatest hover tilt, rad: in roll and in pitch, where the tip counts in both together.
        thrust_margin: share of each rotor's range of thrusts that hover keeps from both of its ends.
        leak: greatest |X_xy| and |X_xz| of `tip_force_map`, what a push across the surface adds to the
            pressing force; inf where it does not count.
        sideways: least X_yy of `tip_force_map`; -inf where it does not count.
        effort: greatest `lateral_effort`, rad/N; inf where it does not count. It makes the search ten times
            as long.
        reachable: search the postures within the joint limits, not all that are described.

    Raises:
        ConfigError: a value that makes no sense.
    """

    purpose: str
    degree: int = 7
    smoothing: float = 0.03
    slope: float = 1.95
    tilt: float = 5e-4
    thrust_margin: float = 0.0
    leak: float = math.inf
    sideways: float = -math.inf
    effort: float = math.inf
    reachable: bool = False

    def __post_init__(self) -> None:
        owner = "vectoring criteria"
        require_range(owner, "degree", self.degree, 3, 15)
        require_non_negative(owner, "smoothing", self.smoothing, "N m")
        require_positive(owner, "slope", self.slope, "rad/rad")
        require_range(owner, "tilt", self.tilt, 1e-6, 0.5, "rad")
        require_range(owner, "thrust_margin", self.thrust_margin, 0.0, 0.45)
        for name in ("leak", "effort"):
            if not getattr(self, name) > 0.0:
                raise ConfigError(f"{owner}.{name} = {getattr(self, name)} must be positive, or inf for none")
        if not self.sideways < math.inf:
            raise ConfigError(f"{owner}.sideways = {self.sideways} must be a number, or -inf for none")

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
        posture = robot.description.posture
        if not self.reachable:
            return posture.theta_min, posture.theta_max
        family = posture_family(robot)
        return family.theta_min, family.theta_max


TORQUE = VectoringCriteria("torque")
"""Most guaranteed torque without hover tilt, over all described postures."""

CONTACT = VectoringCriteria(
    "contact", tilt=0.1, effort=0.5, thrust_margin=0.15, leak=0.1, sideways=0.0, reachable=True
)
"""Most guaranteed torque where a push across the surface hardly reaches the pressing force.

For hydrus_xi_quad the search finds no continuous path with 0.04 rad of tilt, nor with a leak of 0.05. With
0.05 rad the lateral effort is up to 1.6 rad/N, with 0.1 rad 0.5 rad/N.
"""
