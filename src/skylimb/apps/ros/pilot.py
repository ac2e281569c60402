"""The lab's flight states around a guarded controller: orders and measurements in, commands out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from skylimb.analysis.exchange.body import Bodies, Body
from skylimb.analysis.exchange.lab_topics import MOCAP
from skylimb.analysis.exchange.messages import Joints
from skylimb.apps.ros.airborne import Airborne
from skylimb.apps.ros.flyer import Flyer
from skylimb.apps.ros.requests import Requests
from skylimb.apps.ros.script import require_from_hover
from skylimb.apps.ros.states import FlightState, Flying, Order, Seen
from skylimb.apps.ros.targets import Form, RefusedError, Shape, Target
from skylimb.apps.ros.tick import Inputs, Received, Tick
from skylimb.apps.ros.transitions import advance
from skylimb.base.errors import unknown_name
from skylimb.control.estimation.records import Measurement, Taken
from skylimb.control.missions.reference import Reference
from skylimb.control.records import Command
from skylimb.flight.realtime.preflight import Check, Measured, checks
from skylimb.flight.realtime.resting_imu import RestingImu
from skylimb.flight.realtime.watchdog import Watchdog

FRESH = 0.1
"""Seconds for which a pose says where the robot is."""

SAG = 0.1
"""By which measured joints may be off the family's postures, as servos give way, rad."""


class Pilot:
    """Flies a robot as its user orders.

    Args:
        flyer: who flies, and with what.

    Attributes:
        flyer: the same.
        flying: the flight's state.
        flight: what is in the air; None on the ground.
    """

    def __init__(self, flyer: Flyer) -> None:
        for name, mission in flyer.missions.items():
            require_from_hover(name, mission)
        self.flyer, robot = flyer, flyer.robot
        self._bodies, self._requests = (
            Bodies(robot, flyer.link),
            Requests(flyer.references.robot, flyer.limits),
        )
        self.flying = Flying()
        self.flight: Airborne | None = None
        # What the IMU says is known in the axes of the link that is seen.
        self._has_imu = robot.description.imu.link == flyer.link
        self._imu = RestingImu(robot.description.gravity)
        self._counts: Counter[str] = Counter()
        self._battery: float | None = None
        self._believed = -np.inf
        self._radio = np.inf
        self._foreign: tuple[str, ...] = ()
        self._now: tuple[Inputs, Body | None] = Inputs(0.0, None, Taken()), None
        self._form = flyer.references.place_of(flyer.first).form
        if flyer.references.plans:
            _ = flyer.references.least  # what plans is made here: it takes longer than a tick of a flight
        # On the ground nothing is flown, but what is measured is judged as in flight.
        self._watch = Watchdog(robot, self.flyer.guard_limits)

    def tick(self, inputs: Inputs) -> Tick:
        """One tick."""
        said, received = list[str](), inputs.received
        stood = self.flyer.pacer.stood_still(self.flyer.guard_limits.overruns)
        if stood:
            self._watch.forget()
        body = self._body(inputs)
        if stood and self.flight is not None:
            self.flight.wake(inputs.now, body)
        self._now = inputs, body
        self._feel(inputs, body)
        self._advance(inputs, body, said)
        if self.flight is not None and self.flying.state == FlightState.HOVER and self.flight.steerable:
            self._lead(self.flight, inputs, said)
        elif self.flying.state == FlightState.ARM_OFF:
            self._pose_on_ground(received, said)
        elif received.requests or received.mission is not None:
            said.append(f"in {self.flying.state.name} the robot is not steered")
            self._counts["request refused"] += len(received.requests) + (received.mission is not None)
        if self.flight is not None:
            return self.flight.fly(self.flying, inputs, body, said)
        q, psi, _, _ = self.flyer.references.posture(self._form)
        command = Command(np.zeros(self.flyer.robot.n_rotors), q, psi)
        return Tick(self.flying, command, False, None, {}, None, body, tuple(said))

    def rehearsed(self) -> tuple[Mapping[str, Any], Reference]:
        """The controller's signals and the reference at a first tick that is not flown."""
        here = self.flyer.references.place_of(self.flyer.first)
        still = np.zeros(3)
        given = self.flyer.held(Target(here, still, still))
        return self.flyer.guard().rehearsed(given, self.flyer.period), given

    def checks(self) -> list[Check]:
        """What is looked at before a flight, as it stands at the last tick."""
        inputs, body = self._now
        # Angles may come and be none, while the pose is known by those that were believed last.
        believed = {} if body is None else {"joint angles": inputs.now - inputs.taken.joints}
        unknown = self._battery is None and self.flyer.needs_battery and self.flyer.cells
        battery = np.nan if unknown else self._battery
        ages = {**inputs.ages, **believed}
        rates = {MOCAP.name: inputs.rate} if MOCAP.name in inputs.ages else {}
        measured = Measured(
            body, ages, inputs.offsets, battery, self._foreign, self._imu.off, None, rates, self._unknown
        )
        found, silent = [*checks(self.flyer.facts, measured, self.flyer.limits)], inputs.now - self._radio
        if np.isfinite(silent):  # it was heard once, and has to be heard on
            most = self.flyer.limits.radio
            found.append(Check("age of the radio", f"{silent:.3g} s", f"at most {most:g}", silent <= most))
        return found

    @property
    def _unknown(self) -> str:
        """Why nobody knows where the robot is."""
        inputs, _ = self._now
        if inputs.missing:
            return f"nothing valid on {', '.join(inputs.missing)}"
        return self._watch.fault or f"the newest pose is {inputs.now - inputs.taken.pose:.3g} s old"

    @property
    def faults(self) -> Counter[str]:
        """How often each fault was met, by name."""
        found = self._counts + self._watch.counts
        return found if self.flight is None else found + self.flight.faults

    def _body(self, inputs: Inputs) -> Body | None:
        """Where the robot is, if that is known and fresh."""
        self._watch.judge(inputs.measurement, inputs.taken.pose)
        good = self._watch.good
        if good is not None and good is inputs.measurement:
            self._believed = inputs.taken.pose
        # A pose that comes and is not believed makes the one before it no fresher.
        return None if good is None or inputs.now - self._believed > FRESH else self._bodies.of(good)

    def _feel(self, inputs: Inputs, body: Body | None) -> None:
        """Listen to the IMU of a robot that stands; one that says no force is none, unless it is flown by."""
        imu = None if inputs.measurement is None else inputs.measurement.imu
        if self.flight is not None or not self._has_imu or imu is None or body is None:
            return
        if self.flyer.plan.needs.imu or np.isfinite(imu.specific_force).all():
            self._imu.take(body.R_W_link @ self.flyer.robot.description.imu.R, np.zeros(3), imu)

    def _advance(self, inputs: Inputs, body: Body | None, said: list[str]) -> None:
        """The flight states, and what begins and ends with them."""
        before, known = self.flying, self._foreign
        seen = self._seen(inputs, body)
        if self.flight is not None and (others := set(seen.foreign) - set(known)):
            said += [f"{other} commands the robot as well: end it" for other in sorted(others)]
            self._counts["another node commands the robot"] += 1
        self.flying, words = advance(before, seen, self.flyer.limits)
        said.extend(words)
        state, landing = self.flying.state, self.flying.state == FlightState.LAND
        if state != before.state or self.flying.force_landing != before.force_landing:
            forced = " by force" if landing and self.flying.force_landing else ""
            said.append(f"{before.state.name} -> {state.name}{forced}")
        if self.flying.in_air and self.flight is None and body is not None:
            # It rises, or comes down from a flight that somebody else began.
            good = self._watch.good
            rises = state == FlightState.TAKEOFF
            form = self._form if rises or good is None else self._found(good)
            self.flight = Airborne(self.flyer, inputs.now, body, form, rises)
            before = Flying()
        if self.flight is not None and landing and before.state != state:
            self.flight.land(inputs.now)
        elif self.flight is not None and not self.flying.in_air:
            self._counts += self.flight.faults
            self._form, self.flight = self.flight.form, None

    def _found(self, measured: Measurement) -> Form:
        """How a robot is bent that flies already."""
        theta = self._requests.in_family(measured.joint_angles, SAG)
        return Shape(measured.joint_angles, measured.vectoring_angles) if theta is None else theta

    def _seen(self, inputs: Inputs, body: Body | None) -> Seen:
        """What the flight states judge by."""
        flight, target, received = self.flight, None, inputs.received
        self._battery = self._battery if received.battery is None else received.battery
        self._foreign = self._foreign if received.foreign is None else received.foreign
        self._radio = self._radio if received.radio is None else received.radio
        silent = "the radio is silent" if inputs.now - self._radio > self.flyer.limits.radio else ""
        begins = not {Order.START, Order.TAKEOFF}.isdisjoint(received.orders) and flight is None
        refused = [str(one) for one in self.checks() if not one.fine] if begins else []
        if flight is not None and self.flying.state == FlightState.TAKEOFF:
            target = flight.end_of_targets
        elif flight is not None and flight.reference is not None and not flight.goes_back:
            target = np.asarray(flight.reference.position)
        return Seen(
            inputs.now,
            None if body is None else body.cog,
            0.0 if body is None else -float(body.velocity[2]),
            target,
            received.orders,
            received.acknowledged,
            # The last good one stays valid in flight; no flight begins with one that is none.
            None if received.battery is None or np.isnan(received.battery) else received.battery,
            "" if flight is None else flight.broken(body) or silent,
            tuple(refused),
            received.armed,
            received.carried,
            inputs.rest,
            flight is not None and flight.cut,
            # Whom nobody commands here the flight controller brings down by itself.
            flight is None or flight.thrust.light,
            self._foreign,
        )

    def _lead(self, flight: Airborne, inputs: Inputs, said: list[str]) -> None:
        """Lead a robot that hovers where its user asks."""
        if inputs.received.taken_over:
            flight.take_over(inputs.now, said)
        for request in inputs.received.requests:
            with self._refusals(type(request).__name__.lower(), said):
                flight.lead_to(self._requests, request, inputs)
        name = inputs.received.mission
        if name is not None and name not in self.flyer.missions:
            said.append(str(unknown_name("mission", name, self.flyer.missions)))
            self._counts["request refused"] += 1
        elif name is not None:
            with self._refusals(f"mission '{name}'", said):
                flight.begin_mission(name, self.flyer.missions[name], inputs.now)
                said.append(f"mission '{name}': on the way to its beginning")

    def _pose_on_ground(self, received: Received, said: list[str]) -> None:
        """Joints may be moved where nothing flies; they go at their servos' own speed."""
        for request in received.requests:
            with self._refusals(type(request).__name__.lower(), said):
                if not isinstance(request, Joints):
                    raise RefusedError("nothing flies")
                references = self.flyer.references
                joints = self._requests.joints(request, references.shape(self._form).joints)
                theta = self._requests.in_family(joints)
                self._form = references.on_ground(joints) if theta is None else theta
        if received.mission is not None:
            with self._refusals(f"mission '{received.mission[:60]}'", said):
                raise RefusedError("nothing flies")

    @contextmanager
    def _refusals(self, what: str, said: list[str]) -> Iterator[None]:
        """Say and count that something is refused, if it is."""
        try:
            yield
        except RefusedError as error:
            said.append(f"{what} refused: {error}")
            self._counts["request refused"] += 1
