"""The lab's robot without ROS: pilot and simulated plant in step, on a clock of their own."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from moment import again
from short_flights import CIRCLE
from skylimb.analysis.exchange.frames import lab_link
from skylimb.apps.ros.flyer import Flyer
from skylimb.apps.ros.grounded import GroundedPlant
from skylimb.apps.ros.pilot import Pilot
from skylimb.apps.ros.states import FlightState, Order
from skylimb.apps.ros.tick import Inputs, Received, Tick
from skylimb.control.estimation.records import Measurement, Taken
from skylimb.flight.realtime.clocked_flight import compiled
from skylimb.flight.realtime.compiled_controller import CompiledController
from skylimb.flight.realtime.pacer import stepped
from skylimb.flight.takeoff import Takeoff, take_off


@functools.cache
def ready(controller: str) -> tuple[Takeoff, CompiledController]:
    return made_ready("paper", controller, CIRCLE)


def made_ready(
    experiment: str, controller: str, keys: Mapping[str, Any]
) -> tuple[Takeoff, CompiledController]:
    (takeoff,) = take_off(experiment, (controller,), set=keys)
    return takeoff, compiled(takeoff, tells=True)


class Steered:
    """Ticks of pilot and plant; whoever acknowledges does so at the next tick.

    Args:
        controller: a preset's name.
        plant: keys of a plant that is not what the controller believes.
    """

    def __init__(self, controller: str = "hybrid", plant: Mapping[str, Any] = MappingProxyType({})) -> None:
        self.takeoff, chosen = ready(controller)
        self.robot, period = self.takeoff.robot, self.takeoff.period
        (really,) = take_off("paper", (controller,), set={**CIRCLE, **plant})
        self.plant = GroundedPlant(really if plant else self.takeoff)
        self.k, self.pacer = 0, stepped(period)
        missions = {"paper": self.takeoff.mission}
        self.pilot = Pilot(Flyer(self.takeoff, chosen, missions, lab_link(self.robot), self.pacer, 0))
        self.acknowledges, self.measures = True, True
        self.battery: float | None = None
        self.said: list[str] = []
        self.ticks: list[Tick] = []
        self.rows: list[np.ndarray] = []
        self._taken, self._measurement = -np.inf, None
        self.pacer.start()

    @property
    def state(self) -> FlightState:
        return self.pilot.flying.state

    @property
    def height(self) -> float:
        body = self.ticks[-1].body
        assert body is not None
        return float(body.cog[2])

    def tick(
        self,
        *orders: Order,
        requests: tuple[Any, ...] = (),
        mission: str | None = None,
        spoil: Any = None,
        received: Received | None = None,
    ) -> Tick:
        self.pacer.wait(self.k)
        measured: Measurement | None = self.plant.measure()
        now = self.pacer.time()
        if spoil is not None:
            measured = spoil(measured)
        if self.measures:
            self._taken, self._measurement = now, measured
        arming = self.pilot.flying.arming
        acknowledged = int(arming) if arming is not None and self.acknowledges else None
        received = received or Received(orders, requests, mission, battery=self.battery)
        received = dataclasses.replace(received, acknowledged=acknowledged)
        tick = self.pilot.tick(Inputs(now, self._measurement, Taken(self._taken, self._taken), received))
        self.rows.append(self.plant.record(self._measurement or measured, tick.command).copy())  # type: ignore[arg-type]
        self.plant.apply(tick.driven)
        self.k += 1
        self.said += tick.said
        self.ticks.append(tick)
        return tick

    def fly(self, seconds: float) -> None:
        for _ in range(round(seconds / self.takeoff.period)):
            self.tick()

    def until(self, state: FlightState, seconds: float = 30.0) -> None:
        for _ in range(round(seconds / self.takeoff.period)):
            if self.state == state:
                return
            self.tick()
        raise AssertionError(f"{self.state.name} after {seconds} s, wanted {state.name}: {self.said}")

    def hover(self) -> None:
        """On the ground to hover."""
        self.tick()
        self.tick(Order.START)
        self.until(FlightState.ARM_ON)
        self.tick(Order.TAKEOFF)
        self.until(FlightState.HOVER)


def in_hover(controller: str = "hybrid") -> Steered:
    """One that hovers; what has been done with it since is undone."""
    return again(_hovering, controller)


def _hovering(controller: str) -> Steered:
    robot = Steered(controller)
    robot.hover()
    return robot
