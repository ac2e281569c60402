"""The lab's flight states around a guarded controller: orders, wishes and measurements in, commands out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from skylimb.control.controller import Controller
from skylimb.control.needs import PACE, needs_of
from skylimb.control.records import Command
from skylimb.control.thrusts import thrust_limits
from skylimb.errors import unknown_name
from skylimb.estimation.records import Measurement
from skylimb.missions.mission import Mission
from skylimb.missions.reference import Reference
from skylimb.missions.table import window_of
from skylimb.realtime.guard import BLIND, GuardedController
from skylimb.realtime.pacer import Pacer
from skylimb.realtime.watchdog import Limits, Watchdog
from skylimb.robots.model import Robot
from skylimb.ros1.body import Bodies, Body
from skylimb.ros1.landing import Landing
from skylimb.ros1.limits import FlightLimits
from skylimb.ros1.messages import Joints
from skylimb.ros1.references import References
from skylimb.ros1.script import Script, after_tick, require_from_hover
from skylimb.ros1.states import FlightState, Flying, Order, Seen, advance
from skylimb.ros1.targets import Place, Target, Targets, duration_of
from skylimb.ros1.wishes import Refused, Wish, Wishes

SPOOL_TIME, SPOOL_SHARE = 1.0, 0.9
"""Seconds in which the rotors come up on the ground, and the share of the hover thrusts that they come to."""

RISE = 0.3
"""Speed of a take-off, m/s."""

FLOOR = -0.5
"""Height at which the descent of a retreat ends, m: below any ground, as what stands does not sink."""


@dataclass(frozen=True)
class Inputs:
    """What came since the last tick.

    Attributes:
        now: the pacer's time, s.
        measurement: the newest one; None while there has been none.
        taken: when it was measured, s.
        orders: of a user, in their order.
        wishes: of a user, in their order, each with what is to be added to its stamp for our clock, s.
        mission: that is to be flown; empty for none.
        acknowledged: the last command that the flight controller acknowledged since then.
        battery: charge, per cent.
    """

    now: float
    measurement: Measurement | None
    taken: float
    orders: tuple[Order, ...] = ()
    wishes: tuple[tuple[Wish, float], ...] = ()
    mission: str = ""
    acknowledged: int | None = None
    battery: float | None = None


@dataclass(frozen=True)
class Tick:
    """What a tick came to.

    Attributes:
        flying: the flight's state.
        command: to the actuators; thrusts are zero where the motors are off.
        motors: whether the thrusts mean anything.
        reference: that the controller was given; None where none flew.
        signals: the controller's own; empty where none flew.
        script: the mission under way as this tick flew it; None without one.
        body: centre of gravity and the lab's link as measured; None where nothing fresh is.
        said: to people, one line each.
    """

    flying: Flying
    command: Command
    motors: bool
    reference: Reference | None
    signals: Mapping[str, Any]
    script: Script | None
    body: Body | None
    said: tuple[str, ...]


class Pilot:
    """Flies a robot as its user orders.

    Args:
        robot: what flies.
        controller: makes the controller of a flight.
        missions: that can be flown from hover, by name; the first one gives contact axis and reach.
        link: whose pose is on the lab's topics.
        pacer: of the ticks.
        period: of the ticks, s.
        limits: of the flight states.
        guard_limits: when to hold and when to retreat.
    """

    def __init__(
        self,
        robot: Robot,
        controller: Controller,
        missions: Mapping[str, Mission],
        link: str,
        pacer: Pacer,
        period: float,
        limits: FlightLimits | None = None,
        guard_limits: Limits | None = None,
    ) -> None:
        for name, mission in missions.items():
            require_from_hover(name, mission)
        self.robot, self.missions, self.period = robot, missions, period
        self._controller, self._pacer = controller, pacer
        self._limits, self._guard_limits = limits or FlightLimits(), guard_limits or Limits()
        self._needs, self._bodies = needs_of(controller), Bodies(robot, link)
        self._preview = window_of(self._needs.preview, False, period).preview
        first = next(iter(missions.values())).first
        self.references = References(robot, link, first, self._needs.vectoring)
        self._wishes = Wishes(robot, self._limits)
        self._joints, self._bounds = robot.joint_limits(), thrust_limits(robot)
        self.flying = Flying()
        self.counts: Counter[str] = Counter()
        self._theta = self.references.place_of(first).theta
        # On the ground nothing is flown, but what is measured is judged as in flight.
        self._watch = Watchdog(robot, self._guard_limits)
        self._end_flight(None)

    def tick(self, inputs: Inputs) -> Tick:
        """One tick."""
        said = list[str]()
        body = self._body(inputs)
        self._advance(inputs, body, said)
        if self.flying.state == FlightState.HOVER and not self._fault():
            self._fulfil(inputs, said)
        elif self.flying.state == FlightState.ARM_OFF:
            self._pose_on_ground(inputs, said)
        elif inputs.wishes or inputs.mission:
            said.append(f"in {self.flying.state.name} the robot is not steered")
            self.counts["wish refused"] += len(inputs.wishes) + bool(inputs.mission)
        if self.flying.in_air:
            return self._fly(inputs, body, said)
        q, psi, _, _ = self.references.posture(self._theta)
        command = Command(np.zeros(self.robot.n_rotors), q, psi)
        return Tick(self.flying, command, False, None, {}, None, body, tuple(said))

    def rehearsed(self) -> tuple[Mapping[str, Any], Reference]:
        """The controller's signals and the reference at a first tick that is not flown."""
        first = next(iter(self.missions.values())).first
        here = self.references.place_of(first)
        still = np.zeros(3)
        reference = self.references.at(Target(here, still, still))
        given = reference._replace(ahead=(reference,) * len(self._preview))
        guard = GuardedController(self._controller, self.robot, self._pacer, self._guard_limits, FLOOR)
        level = np.array([1.0, 0.0, 0.0, 0.0])
        posture = reference.joint_angles, reference.vectoring_angles
        measured = Measurement(here.position, level, still, still, *posture)
        _, _, own = guard.step(guard.gains(), guard.initial_state(), measured, given, self.period)
        return own, given

    @property
    def faults(self) -> Counter[str]:
        """How often each fault was met, by name."""
        found = self.counts + self._watch.counts
        return found if self._guard is None else found + self._guard.counts + self._guard.watchdog.counts

    def _body(self, inputs: Inputs) -> Body | None:
        """Where the robot is, if that is known and fresh."""
        if inputs.measurement is None and self._watch.good is None:
            return None  # nobody has measured anything yet
        self._watch.judge(inputs.measurement, inputs.taken, inputs.now)
        good = self._watch.good
        if good is None or inputs.now - inputs.taken > self._guard_limits.hold_after:
            return None
        return self._bodies.of(good)

    def _advance(self, inputs: Inputs, body: Body | None, said: list[str]) -> None:
        """The flight states, and what begins and ends with them."""
        reference = self._guard.flown if self._guard is not None else None
        target = None if reference is None else np.asarray(reference.position)
        if self.flying.state == FlightState.TAKEOFF:
            target = (
                self._targets.legs[-1].end.position if self._targets.legs else self._targets.place.position
            )
        seen = Seen(
            inputs.now,
            None if body is None else body.cog,
            0.0 if body is None else -float(body.velocity[2]),
            target,
            inputs.orders,
            inputs.acknowledged,
            inputs.battery,
            self._broken(body, reference),
        )
        before = self.flying
        self.flying, words = advance(before, seen, self._limits)
        said.extend(words)
        if self.flying.state == before.state and self.flying.force_landing == before.force_landing:
            return
        said.append(f"{before.state.name} -> {self.flying.state.name}")
        if self.flying.state == FlightState.TAKEOFF and body is not None:
            self._begin_flight(inputs.now, body)
        elif self.flying.state == FlightState.LAND and before.state != FlightState.LAND:
            touching = self._script is not None and self._script.begun and self._script.mission.contact
            if reference is not None:
                self._landing = Landing(reference, inputs.now, touching, self._limits.descent)
            self._script = None
        elif not self.flying.in_air:
            self._end_flight(body)

    def _broken(self, body: Body | None, reference: Reference | None) -> str:
        """Why a flight has to be broken off; empty while it has not."""
        if self._guard is None or self._failure:
            return self._failure
        if self._guard.retreating:
            return "broken off by the guard"
        if body is None or reference is None:
            return ""
        if body.tilt > self._limits.tilt:
            return f"tilt above {self._limits.tilt:g} rad"
        # A robot that stands is not where its landing leads.
        away = np.asarray(reference.position) - body.cog
        if float(np.linalg.norm(away[:2])) > self._limits.astray:
            return f"more than {self._limits.astray:g} m from the reference"
        return ""

    def _fault(self) -> bool:
        return self._guard is not None and (self._guard.retreating or bool(self._failure))

    def _begin_flight(self, now: float, body: Body) -> None:
        """The rotors come up; then a new controller begins."""
        here = Place(body.cog, body.yaw, self._theta)
        above = here._replace(position=np.array([*body.cog[:2], self._limits.takeoff_height]))
        self._spool = now + SPOOL_TIME
        duration = max(duration_of(here, above, self._limits, RISE), self._limits.shortest_way)
        self._targets = Targets(here, self._spool).go(above, self._spool, duration)
        guard = GuardedController(self._controller, self.robot, self._pacer, self._guard_limits, FLOOR)
        self._guard, self._gains, self._state = guard, guard.gains(), guard.initial_state()
        q, psi, _, _ = self.references.posture(self._theta)
        self._hover = np.asarray(self.robot.at(q, psi).hover_thrusts)
        self._landing = self._script = None
        self._failure = ""

    def _end_flight(self, body: Body | None) -> None:
        if getattr(self, "_guard", None) is not None:
            self.counts += self._guard.counts + self._guard.watchdog.counts
        self._guard: Any = None
        self._gains = self._state = self._landing = self._script = None
        self._failure = ""
        self._spool, self._hover = 0.0, np.zeros(self.robot.n_rotors)
        here = np.zeros(3) if body is None else body.cog
        self._targets = Targets(Place(here, 0.0, self._theta), 0.0)

    def _fulfil(self, inputs: Inputs, said: list[str]) -> None:
        """What a user wishes of a robot that hovers."""
        for wish, offset in inputs.wishes:
            if self._script is not None:
                made: Targets | Refused = Refused(f"mission '{self._script.name}' is being flown")
            else:
                made = self._wishes.fulfilled(self._targets, wish, inputs.now, offset)
            if isinstance(made, Refused):
                said.append(f"{type(wish).__name__.lower()} refused: {made.why}")
                self.counts["wish refused"] += 1
            else:
                self._targets = made
        if inputs.mission:
            self._begin_mission(inputs, said)

    def _begin_mission(self, inputs: Inputs, said: list[str]) -> None:
        name = inputs.mission
        if name not in self.missions:
            said.append(str(unknown_name("mission", name, self.missions)))
            self.counts["wish refused"] += 1
        elif self._script is not None:
            said.append(f"mission '{name}' refused: '{self._script.name}' is being flown")
            self.counts["wish refused"] += 1
        else:
            self._script = Script(name, self.missions[name])
            there = self.references.place_of(self.missions[name].first)
            here = self._targets.at(inputs.now)[0].place
            self._targets = self._targets.go(there, inputs.now, duration_of(here, there, self._limits))
            said.append(f"mission '{name}': on the way to its beginning")

    def _pose_on_ground(self, inputs: Inputs, said: list[str]) -> None:
        """Joints may be moved where nothing flies; they go at their servos' own speed."""
        for wish, _ in inputs.wishes:
            theta: float | Refused = Refused("nothing flies")
            if isinstance(wish, Joints):
                theta = self._wishes.shape_angle(wish, self._theta)
            if isinstance(theta, Refused):
                said.append(f"{type(wish).__name__.lower()} refused: {theta.why}")
                self.counts["wish refused"] += 1
            else:
                self._theta = theta
        if inputs.mission:
            said.append(f"mission '{inputs.mission}' refused: nothing flies")
            self.counts["wish refused"] += 1

    def _fly(self, inputs: Inputs, body: Body | None, said: list[str]) -> Tick:
        now, guard = inputs.now, self._guard
        if now < self._spool:
            return self._spooled(now, body, said)
        reference, script = self._reference(now, body)
        measurement = inputs.measurement or _nothing(self.robot)
        guard.taken(inputs.taken)
        try:
            self._state, command, own = guard.step(
                self._gains, self._state, measurement, reference, self.period
            )
        except Exception as error:  # a user's own controller: the robot must come down all the same
            return self._failed(error, reference, body, said)
        flown = guard.flown or reference
        if script is not None and script.begun:
            pace = float(own[PACE]) if self._needs.paced else None
            self._script = after_tick(script, pace)
            self._end_mission(now, said)
        return Tick(self.flying, command, True, flown, own, script, body, tuple(said))

    def _spooled(self, now: float, body: Body | None, said: list[str]) -> Tick:
        """The rotors on their way to nearly carrying the robot."""
        part = max(0.0, 1.0 - (self._spool - now) / SPOOL_TIME)
        low, high = self._bounds
        q, psi, _, _ = self.references.posture(self._theta)
        command = Command(np.clip(part * SPOOL_SHARE * self._hover, low, high), q, psi)
        return Tick(self.flying, command, True, None, {}, None, body, tuple(said))

    def _failed(self, error: Exception, reference: Reference, body: Body | None, said: list[str]) -> Tick:
        """Level and down without a controller: nobody holds the attitude but the flight controller."""
        if not self._failure:
            said.append(f"controller '{self._controller.name}' failed: {error}")
        self._failure = "the controller failed"
        self.counts[self._failure] += 1
        q, psi, _, _ = self.references.posture(self._theta)
        command = Command(np.clip(BLIND * self._hover, *self._bounds), q, psi)
        return Tick(self.flying, command, True, reference, {}, None, body, tuple(said))

    def _reference(self, now: float, body: Body | None) -> tuple[Reference, Script | None]:
        if self._landing is not None:
            height = float(self._landing.last.position[2]) if body is None else float(body.cog[2])
            reference = self._landing.at(now, height)
            return reference._replace(ahead=(reference,) * len(self._preview)), None
        script = self._script
        if script is not None and not script.begun and not self._targets.legs:
            script = self._script = Script(script.name, script.mission, begun=True)
        if script is not None and script.begun:
            return script.reference(self._preview), script
        self._targets, target = self._targets.at(now)
        self._theta = target.place.theta
        reference = self.references.at(target)
        return reference._replace(ahead=(reference,) * len(self._preview)), script

    def _end_mission(self, now: float, said: list[str]) -> None:
        """Back to hover where the mission ends, or away from the surface where it was given up."""
        script = self._script
        if script is None or not (script.over or script.given_up):
            return
        last = script.mission.row(min(int(script.clock.ticks), len(script.mission.times) - 1))
        place = self.references.place_of(last)
        self._targets = self._targets.hold(place, now)
        if script.over:
            said.append(f"mission '{script.name}': flown; hovering at its end")
        else:
            away = place._replace(position=place.position - 0.3 * np.asarray(last.contact_axis))
            self._targets = self._targets.go(away, now, self._limits.shortest_way)
            said.append(f"mission '{script.name}': given up, held back for too long; hovering away from it")
        self._script = None


def _nothing(robot: Robot) -> Measurement:
    """A measurement that nobody believes."""
    z3 = np.full(3, np.nan)
    return Measurement(
        z3, np.full(4, np.nan), z3, z3, np.full(robot.n_joints, np.nan), np.full(robot.n_vectoring, np.nan)
    )
