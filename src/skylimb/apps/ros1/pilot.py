"""The lab's flight states around a guarded controller: orders and measurements in, commands out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from skylimb.analysis.exchange.body import Bodies, Body
from skylimb.analysis.exchange.messages import Joints
from skylimb.apps.ros1.airborne import Airborne
from skylimb.apps.ros1.flyer import Flyer
from skylimb.apps.ros1.requests import RefusedError, Requests
from skylimb.apps.ros1.script import require_from_hover
from skylimb.apps.ros1.states import FlightState, Flying, Seen, advance
from skylimb.apps.ros1.targets import Target
from skylimb.apps.ros1.tick import Inputs, Received, Tick
from skylimb.base.errors import unknown_name
from skylimb.control.estimation.records import Measurement
from skylimb.control.missions.reference import Reference
from skylimb.control.records import Command
from skylimb.flight.realtime.watchdog import Watchdog

FRESH = 0.1
"""Seconds for which a pose says where the robot is."""


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
        self._bodies, self._requests = Bodies(robot, flyer.link), Requests(robot, flyer.limits)
        self.flying = Flying()
        self.flight: Airborne | None = None
        self._counts: Counter[str] = Counter()
        self._theta = flyer.references.place_of(flyer.first).theta
        # On the ground nothing is flown, but what is measured is judged as in flight.
        self._watch = Watchdog(robot, self.flyer.guard_limits)

    def tick(self, inputs: Inputs) -> Tick:
        """One tick."""
        said, received = list[str](), inputs.received
        body = self._body(inputs)
        self._advance(inputs, body, said)
        if self.flight is not None and self.flying.state == FlightState.HOVER and self.flight.steerable:
            self._lead(self.flight, inputs, said)
        elif self.flying.state == FlightState.ARM_OFF:
            self._pose_on_ground(received, said)
        elif received.requests or received.mission:
            said.append(f"in {self.flying.state.name} the robot is not steered")
            self._counts["request refused"] += len(received.requests) + bool(received.mission)
        if self.flight is not None:
            return self.flight.fly(self.flying, inputs, body, said)
        q, psi, _, _ = self.flyer.references.posture(self._theta)
        command = Command(np.zeros(self.flyer.robot.n_rotors), q, psi)
        return Tick(self.flying, command, False, None, {}, None, body, tuple(said))

    def rehearsed(self) -> tuple[Mapping[str, Any], Reference]:
        """The controller's signals and the reference at a first tick that is not flown."""
        here = self.flyer.references.place_of(self.flyer.first)
        still = np.zeros(3)
        given = self.flyer.held(Target(here, still, still))
        guard = self.flyer.guard()
        level = np.array([1.0, 0.0, 0.0, 0.0])
        posture = given.joint_angles, given.vectoring_angles
        measured = Measurement(here.position, level, still, still, *posture)
        _, _, signals = guard.step(guard.gains(), guard.initial_state(), measured, given, self.flyer.period)
        return signals, given

    @property
    def faults(self) -> Counter[str]:
        """How often each fault was met, by name."""
        found = self._counts + self._watch.counts
        return found if self.flight is None else found + self.flight.faults

    def _body(self, inputs: Inputs) -> Body | None:
        """Where the robot is, if that is known and fresh."""
        if inputs.measurement is None and self._watch.good is None:
            return None  # nobody has measured anything yet
        self._watch.judge(inputs.measurement, inputs.taken)
        good = self._watch.good
        if good is None or inputs.now - inputs.taken > FRESH:
            return None
        return self._bodies.of(good)

    def _advance(self, inputs: Inputs, body: Body | None, said: list[str]) -> None:
        """The flight states, and what begins and ends with them."""
        before = self.flying
        self.flying, words = advance(before, self._seen(inputs, body), self.flyer.limits)
        said.extend(words)
        state = self.flying.state
        if state == before.state and self.flying.force_landing == before.force_landing:
            return
        said.append(f"{before.state.name} -> {state.name}")
        if state == FlightState.TAKEOFF and body is not None:
            self.flight = Airborne(self.flyer, inputs.now, body, self._theta)
        elif self.flight is None:
            return
        elif state == FlightState.LAND and before.state != FlightState.LAND:
            self.flight.land(inputs.now)
        elif not self.flying.in_air:
            self._counts += self.flight.faults
            self._theta, self.flight = self.flight.theta, None

    def _seen(self, inputs: Inputs, body: Body | None) -> Seen:
        """What the flight states judge by."""
        flight, target = self.flight, None
        if flight is not None and self.flying.state == FlightState.TAKEOFF:
            target = flight.end_of_targets
        elif flight is not None and flight.reference is not None:
            target = np.asarray(flight.reference.position)
        return Seen(
            inputs.now,
            None if body is None else body.cog,
            0.0 if body is None else -float(body.velocity[2]),
            target,
            inputs.received.orders,
            inputs.received.acknowledged,
            inputs.received.battery,
            "" if flight is None else flight.broken(body),
        )

    def _lead(self, flight: Airborne, inputs: Inputs, said: list[str]) -> None:
        """Lead a robot that hovers where its user asks."""
        for request in inputs.received.requests:
            with self._refusals(type(request).__name__.lower(), said):
                flight.lead_to(self._requests, request, inputs)
        name = inputs.received.mission
        if name and name not in self.flyer.missions:
            said.append(str(unknown_name("mission", name, self.flyer.missions)))
            self._counts["request refused"] += 1
        elif name:
            with self._refusals(f"mission '{name}'", said):
                flight.begin_mission(name, self.flyer.missions[name], inputs.now)
                said.append(f"mission '{name}': on the way to its beginning")

    def _pose_on_ground(self, received: Received, said: list[str]) -> None:
        """Joints may be moved where nothing flies; they go at their servos' own speed."""
        for request in received.requests:
            with self._refusals(type(request).__name__.lower(), said):
                if not isinstance(request, Joints):
                    raise RefusedError("nothing flies")
                self._theta = self._requests.shape_angle(request, self._theta)
        if received.mission:
            with self._refusals(f"mission '{received.mission}'", said):
                raise RefusedError("nothing flies")

    @contextmanager
    def _refusals(self, what: str, said: list[str]) -> Iterator[None]:
        """Say and count that something is refused, if it is."""
        try:
            yield
        except RefusedError as error:
            said.append(f"{what} refused: {error}")
            self._counts["request refused"] += 1
