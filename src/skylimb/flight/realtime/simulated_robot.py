"""The simulated plant behind a link, in place of a robot."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from skylimb.control.records import Command
from skylimb.flight.drivers.world import world
from skylimb.flight.events import PLANT_KINDS, require_applied
from skylimb.flight.flying import simulated_vehicle
from skylimb.flight.realtime.clocked_flight import ticks_on_clock
from skylimb.flight.realtime.link import MOST, Link
from skylimb.flight.realtime.messages import CommandMessage, Names, RefusedMessageError, decode, encode
from skylimb.flight.realtime.pacer import Pacer
from skylimb.flight.takeoff import Takeoff, take_off
from skylimb.simulation.engine_timer import without_timer

LONGER = 120.0
"""Seconds that a flight may take beyond its mission."""

SILENCE = 2.0
"""Seconds without a command after which a robot that has flown stops."""


class SimulatedRobot:
    """Sends what its sensors say at every tick, and does what it was last commanded.

    Its physics, and the time of its events, begin with the first command.

    Args:
        takeoff: what flies; its controller is not used.
        link: to whoever controls it.

    Attributes:
        flown: ticks of physics.
    """

    def __init__(self, takeoff: Takeoff, link: Link) -> None:
        # Whoever controls it may take longer than the mission: to wait, and to land. The noise comes again.
        self._rows = len(takeoff.rows) + round(LONGER / takeoff.period)
        simulated = world(takeoff, np.arange(self._rows) * takeoff.period)
        self._period, self._link, self._names = takeoff.period, link, Names(takeoff.robot)
        self.flown = self._seq = 0
        self._vehicle = simulated_vehicle(takeoff, simulated, takeoff.rows.ticks)
        self._measurement = self._vehicle.measure()
        self._command: Command | None = None
        self._data = simulated.data

    def position(self) -> np.ndarray:
        """Of the measured link, W, m, (3,)."""
        return np.array(self._data.qpos[0:3])

    @property
    def over(self) -> bool:
        """Whether what is known of the flight beforehand is used up."""
        return self.flown >= self._rows - 1

    def sense(self) -> None:
        """Send the state."""
        stamp = self._seq * self._period
        self._link.send(encode(self._names.state_message(self._seq, stamp, self._measurement)))
        self._seq += 1

    def act(self) -> bool:
        """Do what was last commanded for a tick; whether a command has come since the last one."""
        fresh = False
        for datagram in self._link.receive(MOST)[0]:
            try:
                self._command, fresh = self._names.command(decode(datagram.data, CommandMessage)), True
            except RefusedMessageError:
                continue  # whoever sends other things is not flying this robot
        if self._command is not None and not self.over:
            self._vehicle.apply(self._command)
            self._measurement = self._vehicle.measure()
            self.flown += 1
        return fresh


def serve_plant(
    link: Link, experiment: str = "paper", set: Mapping[str, Any] | None = None, pacer: Pacer | None = None
) -> int:
    """Let the plant of an experiment be flown over a link, until its commands stop.

    Args:
        link: to whoever controls it.
        experiment: a name or a TOML file.
        set: dotted keys and new values.
        pacer: of the ticks; the wall clock by default.

    Returns:
        Ticks flown.
    """
    (takeoff,) = take_off(experiment, (None,), set=set)
    require_applied(takeoff.experiment.events, PLANT_KINDS, "a simulated robot behind a link")
    clock, silent = pacer or Pacer(takeoff.period), 0
    with without_timer():
        robot = SimulatedRobot(takeoff, link)
        for _ in ticks_on_clock(clock):
            if robot.over or silent * clock.period >= SILENCE:
                break
            robot.sense()
            fresh = robot.act()
            silent = 0 if fresh or not robot.flown else silent + 1
    return robot.flown
