"""What to fly, as an experiment's file says it: phases, approach and path."""

from __future__ import annotations

from dataclasses import dataclass, field

from skylimb.config import require_non_negative, require_positive, require_range
from skylimb.planning.trajectories import TrajectoryConfig


@dataclass(frozen=True)
class PhaseConfig:
    """Lengths of the phases that wait, s; approach, slide and retreat last as long as their paths.

    Attributes:
        hover: s.
        tare: s.
        settle: s.
        hover_end: s.
        patience: how many times the mission's time a flight may take whose controller holds the mission's
            clock back.
    """

    hover: float = 3.0
    tare: float = 4.0
    settle: float = 5.0
    hover_end: float = 3.0
    patience: float = 2.5

    def __post_init__(self) -> None:
        require_range("phases", "patience", self.patience, 1.0, 20.0)
        for name in ("hover", "tare", "settle", "hover_end"):
            require_non_negative("phases", name, getattr(self, name), "s")


@dataclass(frozen=True)
class ApproachConfig:
    """How the robot comes to the surface and leaves it.

    Attributes:
        depth: how far beyond the surface the undisturbed tip would stand, at the middle of the path, m.
        standoff: gap between tip and surface before the approach, at the middle of the path, m.
        speed: of the approach, m/s.
        retreat_speed: m/s.
        lift: least gap between tip and surface on the way from one stroke of a drawing to the next, m.
        contact: false to stay at the standoff all the while, for a free flight.
    """

    contact: bool = True
    depth: float = 0.18
    standoff: float = 0.10
    speed: float = 0.05
    retreat_speed: float = 0.10
    lift: float = 0.05

    def __post_init__(self) -> None:
        require_range("approach", "depth", self.depth, 0.0, 0.6, "m")
        require_range("approach", "standoff", self.standoff, 0.0, 2.0, "m")
        require_range("approach", "lift", self.lift, 0.0, 1.0, "m")
        require_positive("approach", "speed", self.speed, "m/s")
        require_positive("approach", "retreat_speed", self.retreat_speed, "m/s")


@dataclass(frozen=True)
class MissionConfig:
    """What to fly: phases, approach and path."""

    phases: PhaseConfig = field(default_factory=PhaseConfig)
    approach: ApproachConfig = field(default_factory=ApproachConfig)
    trajectory: TrajectoryConfig = field(default_factory=TrajectoryConfig)
