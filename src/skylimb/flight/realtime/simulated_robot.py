"""The simulated plant behind a link, in place of a robot."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from skylimb.control.records import Command
from skylimb.flight.drivers.world import world
from skylimb.flight.events import PLANT_KINDS, require_applied
from skylimb.flight.flying import simulated_vehicle
from skylimb.flight.realtime.clocked_flight import ticks_on_clock
from skylimb.flight.realtime.faults import Faults
from skylimb.flight.realtime.link import MOST, Datagram, ServedLink
from skylimb.flight.realtime.messages import (
    GREETING,
    CommandMessage,
    Names,
    RefusedMessageError,
    decode,
    encode,
)
from skylimb.flight.realtime.pacer import Pacer
from skylimb.flight.realtime.speaker import Speaker
from skylimb.flight.takeoff import Takeoff, take_off
from skylimb.simulation.engine_timer import without_timer

LONGER = 120.0
"""Seconds that a flight may take beyond its mission."""

SILENCE = 2.0
"""Seconds without a command after which a robot that has flown stops."""


COMMANDED = 1.0
"""Seconds after a command for which who only greets is not answered. A controller's computer that starts
another one may stand still meanwhile, and its robot would be left to one that only looks."""


class SimulatedRobot:
    """Sends what its sensors say at every tick, and does what it was last commanded.

    Its physics, and the time of its events, begin with the first command. It talks to one sender of commands
    or greetings at a time, to another one once that is silent, and to one that only greets a second after the
    last command; commands have numbers that rise.

    Args:
        takeoff: what flies; its controller is not used.
        link: to whoever controls it.

    Attributes:
        flown: ticks of physics.
        counts: how often each fault of a command was met.
    """

    def __init__(self, takeoff: Takeoff, link: ServedLink) -> None:
        # Whoever controls it may take longer than the mission: to wait, and to land. The noise comes again
        # then; events do not.
        self._rows = len(takeoff.rows) + round(LONGER / takeoff.period)
        simulated = world(takeoff, np.arange(self._rows) * takeoff.period)
        self._period, self._link, self._names = takeoff.period, link, Names(takeoff.robot)
        self.flown = self._seq = 0
        self._vehicle = simulated_vehicle(takeoff, simulated)
        self._measurement = self._vehicle.measure()
        self._command: Command | None = None
        self._data = simulated.data
        self._speaker, self._newest = Speaker(), -1
        self._loop_delay: float | None = None
        self._obeyed = -math.inf
        self.counts = Faults()

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
        state = self._names.state_message(self._seq, stamp, self._measurement)
        self._link.send(encode(replace(state, loop_delay=self._loop_delay)))
        self._seq += 1

    def act(self) -> bool:
        """Do what was last commanded for a tick; whether a command has come since the last one."""
        fresh = False
        for datagram in self._link.receive(MOST)[0]:
            try:
                fresh = self._obey(datagram) or fresh
            except RefusedMessageError as refused:
                self.counts.note("robot", str(refused))
        if self._command is not None and not self.over:
            self._vehicle.apply(self._command)
            self._measurement = self._vehicle.measure()
            self.flown += 1
        return fresh

    def _obey(self, datagram: Datagram) -> bool:
        """Take a command, or a greeting; whether it was a command.

        Raises:
            RefusedMessageError: with what is wrong with it.
        """
        message = None if datagram.data == GREETING else decode(datagram.data, CommandMessage)
        command = None if message is None else self._names.command(message)
        now = self._seq * self._period
        looks = message is None and datagram.sender != self._speaker.sender
        if not self._speaker.hears(datagram.sender, now) or (looks and now - self._obeyed < COMMANDED):
            raise RefusedMessageError("second sender")
        before, self._speaker = self._speaker, self._speaker.after(datagram.sender, now)
        if self._speaker.turns > before.turns:  # whoever begins counts anew
            self._newest = -1
            self._link.answer(datagram.sender)
        if message is not None and command is not None:
            if message.seq <= self._newest:
                raise RefusedMessageError("command overtaken or said twice")
            self._command, self._newest, self._obeyed = command, message.seq, now
            self._loop_delay = (self._seq - 1) * self._period - message.stamp
        return command is not None


def serve_plant(link: ServedLink, experiment: str = "paper", set: Mapping[str, Any] | None = None) -> int:
    """Let the plant of an experiment be flown over a link, until its commands stop.

    Args:
        link: to whoever controls it.
        experiment: a name or a TOML file.
        set: dotted keys and new values.

    Returns:
        Ticks flown.
    """
    (takeoff,) = take_off(experiment, (None,), set=set)
    require_applied(takeoff.experiment.events, PLANT_KINDS, "a simulated robot behind a link")
    clock, silent = Pacer(takeoff.period), 0
    with without_timer():
        robot = SimulatedRobot(takeoff, link)
        for _ in ticks_on_clock(clock):
            if robot.over or silent * clock.period >= SILENCE:
                break
            robot.sense()
            fresh = robot.act()
            silent = 0 if fresh or not robot.flown else silent + 1
    return robot.flown
