"""What a pilot flies with: robot, controller, limits and clock; the same from flight to flight."""

from __future__ import annotations

from dataclasses import dataclass

from skylimb.apps.ros1.limits import FlightLimits
from skylimb.apps.ros1.references import References
from skylimb.apps.ros1.targets import Target
from skylimb.control.controller import Controller
from skylimb.control.missions.reference import Reference
from skylimb.flight.realtime.guard import GuardedController
from skylimb.flight.realtime.pacer import Pacer
from skylimb.flight.realtime.watchdog import Limits
from skylimb.robots.model import Robot

FLOOR = -0.5
"""Height at which the descent of a retreat ends, m: below any ground, as what stands does not sink."""


@dataclass(frozen=True)
class PilotSetup:
    """What a pilot flies with.

    Attributes:
        robot: what flies.
        controller: makes the controller of a flight.
        references: of targets and postures.
        limits: of the flight states.
        guard_limits: when to hold and when to retreat.
        pacer: of the ticks.
        period: of the ticks, s.
        preview: ticks ahead that the controller looks at.
        paced: whether the controller scales the time of its mission.
    """

    robot: Robot
    controller: Controller
    references: References
    limits: FlightLimits
    guard_limits: Limits
    pacer: Pacer
    period: float
    preview: tuple[int, ...]
    paced: bool

    def guard(self) -> GuardedController:
        """The controller of a flight, guarded."""
        return GuardedController(self.controller, self.robot, self.pacer, self.guard_limits, FLOOR)

    def held(self, target: Target) -> Reference:
        """The reference of a target that stays where it is as far as the controller looks ahead."""
        reference = self.references.at(target)
        return reference._replace(ahead=(reference,) * len(self.preview))
