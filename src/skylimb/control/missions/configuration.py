"""What to fly, as an experiment's file says it: phases, approach and path."""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Literal

from skylimb.base.keys import Key, configuration, refused
from skylimb.control.missions.excitation import ExcitationConfig
from skylimb.control.missions.wrap import WrapConfig
from skylimb.control.planning.trajectory_config import TrajectoryConfig

LONGEST_PHASE = 600.0
"""Longest time that one phase may wait, s."""

MOST_PATIENCE = 20.0
"""How many times a mission's time a flight may take at most."""


def _waiting(meaning: str) -> Key:
    return Key("s", meaning, low=0.0, high=LONGEST_PHASE)


@configuration
class PhaseConfig:
    """Lengths of the phases that wait; approach, slide and retreat last as long as their paths."""

    hover: Annotated[float, _waiting("time in the air before the tare")] = 3.0
    tare: Annotated[float, _waiting("time over which the bias of the force estimate is averaged")] = 4.0
    settle: Annotated[float, _waiting("time in contact before the slide")] = 5.0
    hover_end: Annotated[float, _waiting("time in the air after the retreat")] = 3.0
    patience: Annotated[
        float,
        Key(
            "",
            "times the mission's time that a flight may take whose controller sets the pace; "
            "at least as long as a path takes that waits all the way",
            1.0,
            MOST_PATIENCE,
        ),
    ] = 2.5


@configuration
class ApproachConfig:
    """How the robot comes to the surface and leaves it."""

    contact: Annotated[bool, Key("", "false to stay at the standoff, for a free flight")] = True
    depth: Annotated[
        float,
        Key(
            "m",
            "how far beyond the surface the undisturbed tip would stand, at the middle of the path",
            low=0.0,
            high=0.6,
        ),
    ] = 0.18
    standoff: Annotated[
        float,
        Key(
            "m",
            "gap between tip and surface before the approach, at the middle of the path",
            low=0.0,
            high=2.0,
        ),
    ] = 0.10
    speed: Annotated[float, Key("m/s", "speed of the approach", above=0.0, high=10.0)] = 0.05
    retreat_speed: Annotated[float, Key("m/s", "speed of the retreat", above=0.0, high=10.0)] = 0.10
    heading: Annotated[
        float,
        Key("rad", "the heading, beside that of the contact axis", low=-1.0, high=1.0),
    ] = 0.0
    lift: Annotated[
        float,
        Key(
            "m",
            "least gap between tip and surface from one stroke of a drawing to the next",
            low=0.0,
            high=1.0,
        ),
    ] = 0.05
    believed_friction: Annotated[
        tuple[float, float],
        Key("", "friction of a surface as it is believed, and the greatest that is not ruled out", 0.0, 3.0),
    ] = (0.4, 0.8)
    believed_lean: Annotated[
        float,
        Key(
            "rad",
            "greatest angle of a surface's normal from the contact axis that is not ruled out",
            0.0,
            1.2,
        ),
    ] = 0.34
    doubtful: Annotated[
        Literal["refuse", "fly"],
        Key(
            "",
            "a commanded force that leaves too little over of what the robot can hold against slope and "
            "friction: refused before take-off, or flown with a warning",
        ),
    ] = "refuse"

    def check(self) -> None:
        """Refuse a greatest friction below the one that is believed."""
        usual, most = self.believed_friction
        if most < usual:
            raise refused(
                self, "believed_friction", "rules out what is believed; the second may not be the smaller"
            )


@configuration
class MissionConfig:
    """What to fly: phases, approach, path, motion to be measured, and what the path is bent around."""

    phases: PhaseConfig = field(default_factory=PhaseConfig)
    approach: ApproachConfig = field(default_factory=ApproachConfig)
    trajectory: TrajectoryConfig = field(default_factory=TrajectoryConfig)
    excitation: ExcitationConfig = field(default_factory=ExcitationConfig)
    wrap: WrapConfig = field(default_factory=WrapConfig)
