"""Who flies, and with what: robot, controller, missions, limits and clock; the same from flight to flight."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from skylimb.analysis.exchange.lab_ticks import Names
from skylimb.analysis.exchange.lab_topics import NAMESPACE
from skylimb.apps.ros.limits import FlightLimits
from skylimb.apps.ros.profile import LAB, Dialect
from skylimb.apps.ros.references import References
from skylimb.apps.ros.targets import Target
from skylimb.control.missions.mission import Mission
from skylimb.control.missions.reference import Reference
from skylimb.control.missions.table import window_of
from skylimb.control.supervisor.limits import Limits
from skylimb.flight.plan import FlightPlan
from skylimb.flight.realtime.guard import GuardedController
from skylimb.flight.realtime.pacer import Pacer
from skylimb.flight.realtime.preflight import PreflightFacts
from skylimb.robots.model import Robot

FLOOR = -0.5
"""Height at which the descent of a retreat ends, m: below any ground, as what stands does not sink."""

SCALED = 1e3
"""Share by which a twist may be off along the way. On ROS it is that of the capture's link: joints that turn
between it and the measured link show at once in the poses and late in the twist."""


@dataclass(frozen=True)
class Flyer:
    """Who flies, and with what.

    Attributes:
        plan: robot, controller and the first mission.
        controller: the same, compiled where it can be.
        missions: that can be flown from hover, by name; the first one gives contact axis and reach.
        link: whose pose is on the lab's topics.
        pacer: of the ticks.
        cells: of the battery; 0 where nobody tells its voltage.
        limits: of the flight states.
        guard_limits: when to hold and when to retreat.
        namespace: of the lab's frames.
        facts: what was found before take-off.
        dialect: how it speaks.
        needs_battery: whether somebody has to tell that voltage; a simulated robot has none.
    """

    plan: FlightPlan
    controller: Any
    missions: Mapping[str, Mission]
    link: str
    pacer: Pacer
    cells: int = 6
    limits: FlightLimits = field(default_factory=FlightLimits)
    guard_limits: Limits = field(default_factory=Limits)
    namespace: str = NAMESPACE
    facts: PreflightFacts = field(default_factory=PreflightFacts)
    dialect: Dialect = LAB
    needs_battery: bool = True

    @property
    def robot(self) -> Robot:
        """What flies."""
        return self.plan.robot

    @property
    def names(self) -> Names:
        """Of joints and frames."""
        return self.dialect.named(self.robot, self.namespace)

    @property
    def period(self) -> float:
        """Of the ticks, s."""
        return self.plan.period

    @property
    def first(self) -> Reference:
        """The first row of the first mission."""
        return next(iter(self.missions.values())).first

    @cached_property
    def references(self) -> References:
        """Of targets and postures."""
        return References(self.robot, self.link, self.first, self.plan.needs.vectoring)

    @cached_property
    def preview(self) -> tuple[int, ...]:
        """Ticks ahead that the controller looks at."""
        return window_of(self.plan.needs.preview, False, self.period).preview

    def guard(self) -> GuardedController:
        """The controller of a flight, guarded."""
        limits = replace(self.guard_limits, floor=FLOOR, twist_share=SCALED)
        return GuardedController(self.controller, self.robot, self.pacer, limits)

    def held(self, target: Target) -> Reference:
        """The reference of a target that stays where it is as far as the controller looks ahead."""
        reference = self.references.at(target)
        return reference._replace(ahead=(reference,) * len(self.preview))
