"""Our controller and a simulated robot over the topics between them, on a clock of their own."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from moment import again
from short_flights import CIRCLE
from skylimb.analysis.exchange import lab_topics as topics
from skylimb.analysis.exchange.frames import lab_link
from skylimb.apps.ros.controlled import Controlled
from skylimb.apps.ros.flyer import Flyer
from skylimb.apps.ros.lab_config import read_lab_config
from skylimb.apps.ros.limits import FlightLimits
from skylimb.apps.ros.messages import Arrived, Outgoing
from skylimb.apps.ros.profile import LAB as LAB_DIALECT
from skylimb.apps.ros.profile import Dialect
from skylimb.apps.ros.simulated import Simulated
from skylimb.apps.ros.states import FlightState
from skylimb.flight.realtime.pacer import stepped
from skylimb.flight.takeoff import take_off
from steered import made_ready, ready

_COMMANDS = {topic.name for topic in topics.ACTUATORS}
FLOWN: tuple[str, str, Mapping[str, Any]] = ("paper", "hybrid", CIRCLE)
"""Experiment, controller and keys that most tests share, made once."""
SOON = FlightLimits(settled_time=0.2)
"""Hover soon, as most tests begin there."""

LAB = Path(__file__).parents[1] / "apps" / "ros" / "lab"


class Wire:
    """Controller and simulator in step; what one says the other hears at the next tick.

    `plant` holds keys of a plant that is not what the controller believes.
    """

    def __init__(
        self,
        files: tuple[str, ...] = ("motor_info.yaml",),
        limits: FlightLimits = SOON,
        dialect: Dialect = LAB_DIALECT,
        flown: tuple[str, str, Mapping[str, Any]] = FLOWN,
        cells: int = 6,
        plant: Mapping[str, Any] = MappingProxyType({}),
    ) -> None:
        experiment, name, keys = flown
        takeoff, controller = ready(name) if flown is FLOWN else made_ready(*flown)
        config = read_lab_config([LAB / name for name in files], takeoff.robot)
        (inner,) = take_off(experiment, (name,), set={**keys, **plant, "controller_rate": 1000.0})
        link = lab_link(takeoff.robot)
        self.pacer = pacer = stepped(takeoff.period)
        self.robot = Simulated(inner, link, pacer, servos=config.servos, dialect=dialect)
        missions = {"paper": takeoff.mission}
        flyer = Flyer(takeoff, controller, missions, link, pacer, cells, limits, dialect=dialect)
        self._made = lambda: Controlled(flyer, config)
        self.pilot = self._made()
        self.spoil: Callable[[Outgoing], Outgoing | None] = lambda one: one
        self.spoil_down: Callable[[Outgoing], Outgoing | None] = lambda one: one
        self.up, self.down = deque[Outgoing](), deque[Outgoing]()
        self.k, self.silent, self.said = 0, False, list[str]()
        self.names, self.where = Counter[str](), list[np.ndarray]()
        self.asked = list[Arrived]()
        pacer.start()

    def tick(self, *orders: str) -> None:
        self.pacer.wait(self.k)
        now = self.pacer.time()

        self.up = deque(kept for one in self.up if (kept := self.spoil(one)) is not None)
        up = [] if self.silent else self.heard(self.up, "/spinal", now)
        came = [*up, *(Arrived(order, None, "/client", now) for order in orders)]
        came += [one._replace(at=now) for one in self.asked]
        self.asked.clear()
        told = [one for one in self.pilot.tick(came, now) if one.topic.name in _COMMANDS]
        self.down += [kept for one in told if (kept := self.spoil_down(one)) is not None]
        self.names.update(one.topic.name for one in self.down)
        self.up += self.robot.tick(self.heard(self.down, "/skylimb", now), now)
        self.names.update(one.topic.name for one in self.up)
        self.where.append(self.robot.plant.truth().position.copy())
        self.k += 1
        if self.pacer.stood_still(self.pilot.caught_up):
            self.pacer.forgive()
        assert self.pilot.last is not None
        self.said += self.pilot.last.said

    def heard(self, messages: deque[Outgoing], sender: str, now: float) -> list[Arrived]:
        """What was said, as it arrives at the other side."""
        found = [Arrived(topic.name, value, sender, now) for topic, value in messages]
        messages.clear()
        return found

    def ask(self, request: Arrived) -> None:
        """A user's request, for the next tick."""
        self.asked.append(request)

    @property
    def armed(self) -> bool:
        """Whether the flight controller's motors turn."""
        return self.robot._spinal.armed

    def sinks(self) -> float:
        """The fastest that it has sunk, m/s."""
        return float(-np.diff(np.array(self.where)[:, 2]).min() / 0.005)

    def fly_alone(self, seconds: float) -> None:
        """Nobody commands the robot."""
        for _ in range(round(seconds / 0.005)):
            self.pacer.wait(self.k)
            self.up = deque(self.robot.tick([], self.pacer.time()))
            self.where.append(self.robot.plant.truth().position.copy())
            self.k += 1

    def stand_still(self, seconds: float) -> None:
        """The controller's computer stands still; what the robot says meanwhile waits for it."""
        self.robot.tick(self.heard(self.down, "/skylimb", self.pacer.time()), self.pacer.time())
        for _ in range(round(seconds / 0.005)):
            self.pacer._sleep(0.005)
            self.up += self.robot.tick([], self.pacer.time())
            self.where.append(self.robot.plant.truth().position.copy())

    def restart(self) -> None:
        """The controller's process was killed; another one begins, and knows nothing."""
        self.pilot = self._made()
        self.said, self.down = [], deque()

    def fly(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.005)):
            self.tick()

    def hover(self) -> None:
        """On the ground to hover."""
        self.fly(0.15)
        self.tick("teleop_command/start")
        self.until(FlightState.ARM_ON, 1.0)
        self.tick("teleop_command/takeoff")
        self.until(FlightState.HOVER, 15.0)

    def until(self, state: FlightState, seconds: float) -> None:
        for _ in range(round(seconds / 0.005)):
            if self.pilot.pilot.flying.state == state:
                return
            self.tick()
        raise AssertionError(f"no {state.name}: {self.said} {self.pilot.faults}")


def in_hover(limits: FlightLimits = SOON) -> Wire:
    """One that hovers; what has been done with it since is undone."""
    return again(_hovering, limits)


def _hovering(limits: FlightLimits) -> Wire:
    wire = Wire(limits=limits)
    wire.hover()
    return wire
