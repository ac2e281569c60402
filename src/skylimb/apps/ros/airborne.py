"""One flight, from the first turn of its rotors to the last: what leads it, and what flies it."""

from __future__ import annotations

from collections import Counter

import numpy as np

from skylimb.analysis.exchange.body import Body
from skylimb.analysis.exchange.messages import Joints
from skylimb.apps.ros.bending import Bending
from skylimb.apps.ros.flyer import Flyer
from skylimb.apps.ros.lift import Lift
from skylimb.apps.ros.requests import Requests
from skylimb.apps.ros.script import Script, after_tick
from skylimb.apps.ros.states import Flying
from skylimb.apps.ros.targets import Form, Place, RefusedError, Shape, Targets, duration_of
from skylimb.apps.ros.thrust import Thrust
from skylimb.apps.ros.tick import Inputs, Request, Tick
from skylimb.control.estimation.calibration import SOUND
from skylimb.control.loop.vehicle import nothing_measured
from skylimb.control.missions.mission import Mission
from skylimb.control.missions.reference import Reference
from skylimb.control.needs import PACE
from skylimb.control.records import Command
from skylimb.control.supervisor.retreat import BACK, retreat
from skylimb.flight.realtime.guard import FAILED

RISE = 0.3
"""Speed of a take-off, m/s."""

LEAD = 0.5
"""How far a landing may lead below a robot that does not sink, m: it stands, and the thrusts go down."""


class Airborne:
    """A guarded controller, led along targets, a mission or a landing.

    Args:
        flyer: who flies, and with what.
        now: s.
        body: where the robot stands.
        form: how it is bent.
        rises: whether it stands, and its rotors begin to turn.

    Attributes:
        targets: where it is led, while no mission or landing does.
        form: that is commanded.
        thrust: what share of its thrusts is commanded.
        script: the mission under way; None without one.
        state: of the controller.
    """

    def __init__(self, flyer: Flyer, now: float, body: Body, form: Form, rises: bool = True) -> None:
        self._flyer, self.form = flyer, form
        limits = flyer.limits
        here = Place(body.cog, body.yaw, form)
        self._above = here._replace(position=np.array([*body.cog[:2], limits.takeoff_height]))
        gravity = flyer.robot.description.gravity
        self.thrust = Thrust(body, rises, gravity, flyer.period, self._hover_thrusts())
        self.targets = Targets(here, now)
        self._guard = flyer.guard()
        self._gains, self.state = self._guard.gains(), self._guard.initial_state()
        self._bounds = flyer.robot.thrust_limits()
        self._landing: Reference | None = None
        self._landing_since = now
        self.script: Script | None = None
        self._failed = ""
        self._back = 0.0
        self._bending: Bending | None = None
        self._refused = Counter[str]()

    @property
    def lift(self) -> Lift:
        """How far its take-off is, and what that has learned."""
        return self.thrust.lift

    @property
    def reference(self) -> Reference | None:
        """That was flown last; None before the first tick under control."""
        return self._guard.flown

    @property
    def goes_back(self) -> bool:
        """Whether it is led aside, away from a surface: until it sinks, a height that stays says nothing."""
        reference = self.reference
        return reference is not None and bool(np.any(np.asarray(reference.velocity)[:2]))

    @property
    def end_of_targets(self) -> np.ndarray:
        """Where the targets lead in the end, W, m, (3,)."""
        if not self.lift.lifted:
            return self._above.position
        legs = self.targets.legs
        return legs[-1].end.position if legs else self.targets.place.position

    @property
    def steerable(self) -> bool:
        """Whether nothing has gone wrong."""
        return not (self._guard.retreating or self._guard.failed)

    @property
    def cut(self) -> bool:
        """Whether the supervisor has cut the rotors."""
        return self._guard.mode == "CUT"

    @property
    def faults(self) -> Counter[str]:
        """How often each fault was met, by name."""
        return self._guard.counts + self._refused

    def broken(self, body: Body | None) -> str:
        """Why the flight has to be broken off; empty while it has not."""
        reference, limits = self.reference, self._flyer.limits
        if self._guard.failed or self._guard.retreating:
            return FAILED if self._guard.failed else self._guard.reason
        if self.lift.failed:
            return f"{self.lift.share:g} times the hover thrusts do not lift it"
        if body is None or reference is None:
            return ""
        outside = limits.outside(body.cog)
        # A robot that stands is not where its landing leads.
        away = (np.asarray(reference.position) - body.cog)[:2]
        reasons = (
            (body.tilt > limits.tilt, f"tilt above {limits.tilt:g} rad"),
            (outside, f"beyond the fence: {outside}"),
            (np.linalg.norm(body.velocity) > limits.speed, f"faster than {limits.speed:g} m/s"),
            (np.linalg.norm(away) > limits.astray, f"more than {limits.astray:g} m from the reference"),
        )
        return next((words for holds, words in reasons if holds), "")

    def wake(self, now: float, body: Body | None) -> None:
        """Lead it down from where it is found after a time in which nobody commanded it."""
        self._guard.wake()
        place = self.targets.at(now)[0].place if body is None else Place(body.cog, body.yaw, self.form)
        self.targets = self.targets.hold(place, now)
        if self._landing is not None:
            self.land(now)

    def land(self, now: float) -> None:
        """Lead it down from here, back from the surface first where it may touch one."""
        touching = self.script is not None and self.script.begun and self.script.mission.contact
        self.thrust.lift = self.lift._replace(lifted=True)
        self._landing, self._landing_since = self.reference or self._flyer.held(self.targets.at(now)[1]), now
        self._back = BACK if touching else 0.0
        self.script = self._bending = None
        self.thrust.hover = self._hover_thrusts()

    def lead_to(self, requests: Requests, request: Request, inputs: Inputs) -> None:
        """Turn a request into targets.

        Raises:
            RefusedError: with the reason, when it cannot be.
        """
        if self.script is not None:
            raise RefusedError(f"mission '{self.script.name}' is being flown")
        if isinstance(request, Joints):
            self._bend_to(requests, request, inputs.now)
        else:
            self.targets = requests.targets(self.targets, request, inputs.now, inputs.stamp_offset)

    def _bend_to(self, requests: Requests, request: Joints, now: float) -> None:
        """Along the family, or by a way that is looked for from the next tick on."""
        references, here = self._flyer.references, self.targets.at(now)[0].place
        shape = references.shape(here.form)
        joints = requests.joints(request, shape.joints)
        theta = requests.in_family(joints)
        self.targets, self._bending = self.targets.hold(here, now), None
        if theta is not None and not isinstance(here.form, Shape):
            there = here._replace(form=theta)
            self.targets = self.targets.go(there, now, duration_of(here, there, self._flyer.limits))
            return
        self._bending = references.bending(shape, joints, theta, self._flyer.limits)

    def _bend(self, now: float, said: list[str]) -> None:
        """A plan further on the way that is looked for; once it is found it is gone."""
        bending = self._bending
        if bending is None:
            return
        bending.plan()
        if bending.refused:
            said.append(f"joints refused: {bending.refused}")
            self._refused["request refused"] += 1
            self._bending = None
        elif bending.done:
            here = self.targets.at(now)[0].place
            there = here._replace(form=bending.ends)
            self.targets = self.targets.go(there, now, bending.duration, tuple(bending.rows))
            self._bending = None

    def begin_mission(self, name: str, mission: Mission, now: float) -> None:
        """Go to the beginning of a mission and fly it.

        Raises:
            RefusedError: while another one is being flown.
        """
        if self.script is not None:
            raise RefusedError(f"'{self.script.name}' is being flown")
        if mission.contact and abs(self.lift.needs - 1.0) > SOUND:
            raise RefusedError(
                f"its rotors needed {self.lift.needs:.2f} times their thrust: it touches nothing"
            )
        path = mission.reference.position
        for place in (path.min(axis=0), path.max(axis=0)):
            if outside := self._flyer.limits.outside(place):
                raise RefusedError(f"it leads beyond the fence: {outside}")
        there = self._flyer.references.place_of(mission.first)
        here = self.targets.at(now)[0].place
        if isinstance(here.form, Shape) or self._bending is not None:
            angles = ", ".join(f"{angle:.2f}" for angle in mission.first.joint_angles)
            raise RefusedError(
                f"it begins in the family of postures; joints_ctrl to ({angles}) rad leads back"
            )
        self.script = Script(name, mission)
        self.targets = self.targets.go(there, now, duration_of(here, there, self._flyer.limits))

    def fly(self, flying: Flying, inputs: Inputs, body: Body | None, said: list[str]) -> Tick:
        """One tick."""
        now, before = inputs.now, self.lift
        self.thrust.next(body, flying.eases)
        if self.lift.lifted > before.lifted:
            self._rise(now, body)
        if self.lift.needs != before.needs:
            said.append(f"the rotors need {self.lift.needs:.2f} times the thrust of the robot's file")
        reference, script = self._lead(now, body, said)
        measurement = inputs.measurement or nothing_measured(self._flyer.robot, self._flyer.plan.needs.imu)
        self._guard.taken(*inputs.taken)
        if inputs.lost and self.steerable and self.lift.lifted:
            self._guard.retreat(inputs.lost)
        state, command, signals = self._guard.step(
            self._gains, self.state, measurement, reference, self._flyer.period
        )
        if self._guard.failed != self._failed:
            self._failed = self._guard.failed
            said.append(f"controller '{self._flyer.controller.name}' failed: {self._failed}")
        if not self.lift.lifted:  # the controller is tried, and what it makes is not flown
            command = self._hovering(self.lift.share)
            self.thrust.commanded(command)
            return Tick(flying, command, True, None, {}, None, body, tuple(said))
        self.state = state
        if script is not None and script.begun:
            self.script = after_tick(script, float(signals[PACE]) if self._flyer.plan.needs.paced else None)
            self._end_mission(self.script, now, said)
        flown, scale = self.reference or reference, self.lift.share
        self.thrust.commanded(command, scale)
        _, _, frames, _ = self._flyer.references.posture(self.form)
        yaw = float(flown.heading) + frames.yaw_in_C - frames.tip_heading
        return Tick(flying, command, True, flown, signals, script, body, tuple(said), yaw, scale)

    def _rise(self, now: float, body: Body | None) -> None:
        """On from where it left the ground, with the thrust that it took."""
        place = self.targets.place
        self.targets = self.targets.hold(place if body is None else place._replace(position=body.cog), now)
        duration = duration_of(self.targets.place, self._above, self._flyer.limits, RISE)
        self.targets = self.targets.go(self._above, now, duration)

    def _hover_thrusts(self) -> np.ndarray:
        """In the posture that is commanded, N, (n,)."""
        q, psi, _, _ = self._flyer.references.posture(self.form)
        return np.asarray(self._flyer.robot.at(q, psi).hover_thrusts)

    def _hovering(self, share: float) -> Command:
        """A share of the hover thrusts, in the posture that is commanded."""
        q, psi, _, _ = self._flyer.references.posture(self.form)
        return Command(np.clip(share * self.thrust.hover, *self._bounds), q, psi)

    def _lead(self, now: float, body: Body | None, said: list[str]) -> tuple[Reference, Script | None]:
        """The reference of now, and the mission that it is of."""
        flyer, script = self._flyer, self.script
        if self._landing is not None:
            height = float(self._landing.position[2] if body is None else body.cog[2])
            reference = retreat(self._landing, now - self._landing_since, height - LEAD, self._back)
            return reference._replace(ahead=(reference,) * len(flyer.preview)), None
        if script is not None and not script.begun and not self.targets.legs:
            script = self.script = Script(script.name, script.mission, begun=True)
        if script is not None and script.begun:
            return script.reference(flyer.preview), script
        self._bend(now, said)
        self.targets, target = self.targets.at(now)
        self.form = target.place.form
        return flyer.held(target), script

    def take_over(self, now: float, said: list[str]) -> None:
        """A user's sticks end a mission."""
        script, self.script = self.script, None
        if script is not None and script.begun:
            self._end_mission(script, now, said, "the radio took over")
        elif script is not None:
            self.targets = self.targets.hold(self.targets.at(now)[0].place, now)
            said.append(f"mission '{script.name}': given up, the radio took over")

    def _end_mission(self, script: Script, now: float, said: list[str], why: str = "") -> None:
        """Back to hover where the mission ends, or away from the surface where it is given up."""
        why = why or ("held back for too long" if script.given_up else "")
        if not (script.over or why):
            return
        last = script.mission.row(min(int(script.clock.ticks), len(script.mission.times) - 1))
        place = self._flyer.references.place_of(last)
        self.targets = self.targets.hold(place, now)
        if script.over:
            said.append(f"mission '{script.name}': flown; hovering at its end")
        else:
            away = place._replace(position=place.position - BACK * np.asarray(last.contact_axis))
            self.targets = self.targets.go(away, now, self._flyer.limits.shortest_way)
            said.append(f"mission '{script.name}': given up, {why}; hovering away from it")
        self.script = None
