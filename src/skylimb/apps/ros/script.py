"""A mission that begins and ends in hover: the way to its first row, its rows, and hover at its last one."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.control.missions.clock import Clock, next_clock, start_of_mission
from skylimb.control.missions.mission import Mission
from skylimb.control.missions.reference import Reference

MOVED_POSTURE = 1e-9
"""Radians by which the nominal posture of a mission may move."""


@dataclass(frozen=True)
class Script:
    """A mission under way.

    Attributes:
        name: of the mission.
        mission: its table.
        ticks: flown of it; 0 on the way to its first row.
        clock: where the flight is on it.
        begun: whether the first row was reached.
    """

    name: str
    mission: Mission
    ticks: int = 0
    clock: Clock = field(default_factory=start_of_mission)
    begun: bool = False

    @property
    def over(self) -> bool:
        """Whether all rows were flown."""
        return int(self.clock.ticks) > len(self.mission.times) - 1

    @property
    def given_up(self) -> bool:
        """Whether the flight was held back for longer than the mission's patience."""
        return self.ticks >= len(self.mission.flight_times(True))

    def reference(self, preview: tuple[int, ...]) -> Reference:
        """The row of now."""
        return self.mission.at(self.clock, preview)


def after_tick(script: Script, pace: float | None) -> Script:
    """The script one tick later.

    Args:
        script: as it was flown.
        pace: that the controller set; None for one that sets none.
    """
    clock = Clock(script.ticks + 1.0, 1.0) if pace is None else next_clock(script.clock, pace)
    return Script(script.name, script.mission, script.ticks + 1, clock, True)


def require_from_hover(name: str, mission: Mission) -> None:
    """Raise a `ConfigError` for a mission that leaves the robot in another posture than it began in."""
    if np.ptp(mission.reference.joint_angles, axis=0).max(initial=0.0) > MOVED_POSTURE:
        raise ConfigError(
            f"mission '{name}' moves the joints (posture.waypoints); it cannot be flown from hover"
        )
