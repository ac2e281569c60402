"""A robot behind a link as a vehicle: messages in, messages out, and nothing that a link does surprises."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Hashable, Iterable
from typing import Any, NamedTuple, Protocol

import numpy as np

from skylimb.analysis.exchange.body import Body
from skylimb.control.estimation.records import ABSENT, Measurement
from skylimb.control.estimation.stamps import Stamps, believed, judged
from skylimb.control.loop.vehicle import measured_layout, nothing_measured
from skylimb.control.records import Command
from skylimb.flight.realtime.faults import Faults
from skylimb.flight.realtime.messages import (
    GREETING,
    Names,
    RefusedMessageError,
    StateMessage,
    decode,
    encode,
)
from skylimb.flight.realtime.preflight import Measured
from skylimb.flight.realtime.resting_imu import ImuOff
from skylimb.flight.realtime.speaker import Speaker
from skylimb.flight.realtime.watchdog import Watchdog
from skylimb.robots.model import Robot

MOST = 32
"""Datagrams that are read at a tick; of a flood the rest is thrown away unread."""
ANOTHER = "another sender is listened to"
"""Name of a fault: whoever spoke has been silent, and somebody else speaks."""
DELAY_OVER = 0.5
"""For so long the least of the loop's delays counts, s: messages that are late at times are no slow loop."""
_SETTLING = 3
"""Times that is read until what lay in the queue from before has gone."""


class Datagram(NamedTuple):
    """What came over a link.

    Attributes:
        data: of a message.
        sender: from whom.
        stranger: whether somebody else was named as the one to listen to.
    """

    data: bytes
    sender: Hashable
    stranger: bool = False


class Link(Protocol):
    """Carries datagrams; one file a middleware."""

    def receive(self, most: int) -> tuple[Iterable[Datagram], int]:
        """Up to `most` datagrams that have come, and how many more were thrown away; never waits."""
        ...

    def send(self, data: bytes) -> None:
        """Send one; a link that is down loses it."""
        ...


class ServedLink(Link, Protocol):
    """A link of who is flown: it knows whom to answer."""

    def answer(self, sender: Any) -> None:
        """Send to whoever sent something from now on."""
        ...


class RemoteVehicle:
    """A vehicle behind a link.

    One sender is listened to, the first that was understood; another one once that has been silent
    (`speaker`), through the same checks. A measurement that has not come stands for the
    one before; how old it is goes to whoever guards the flight.

    Args:
        robot: what flies.
        link: carries the messages.
        now: a clock that never goes back, s.
        taken: called with when the measurement of a tick was taken, s on that clock.
        imu: whether an IMU's measurements are needed; messages without them are none then.

    Attributes:
        layout: measurement and command: nobody knows more of a robot.
        counts: how often each fault was met.
        heard: the last state that was understood; None before the first one.
        loop_delay: how long lately at least it took from a measurement to the command that answers it, s, as
            the robot says; 0 while it says nothing.
    """

    def __init__(
        self,
        robot: Robot,
        link: Link,
        now: Callable[[], float],
        taken: Callable[[float], None] = lambda time: None,
        imu: bool = False,
    ) -> None:
        self._names, self._link, self._now, self._taken = Names(robot), link, now, taken
        self._robot = robot
        self._speaker = Speaker()
        self._link.receive(MOST)  # what lies there from before
        self._stamps, self._sent = Stamps(), 0
        # How the clocks stood at first: the first messages may have lain in the queue for a while.
        self._first, self._settling = math.inf, _SETTLING
        self.heard: StateMessage | None = None
        self.counts = Faults()
        self.loop_delay, self._delays = 0.0, deque[tuple[float, float]]()
        self._imu, self._measured = imu, nothing_measured(robot, imu)
        self.layout = measured_layout(robot, imu)

    def known(self, body: Callable[[Measurement], Body], imu: ImuOff | None) -> Measured:
        """What is known of it before a flight; its clock is held against ours of the first messages.

        Args:
            body: of a measurement.
            imu: how far off its IMU is; None where it sends none.
        """
        watch, state = Watchdog(self._robot), self.heard
        watch.judge(self._measured, self._stamps.taken)
        return Measured(
            None if watch.good is None else body(watch.good),
            {"state": self._now() - self._stamps.at + self._measured.capture_age},
            {"state": self._stamps.offset - self._first},
            None if state is None else state.battery,
            None,
            imu,
        )

    def greet(self) -> None:
        """Tell a robot that waits where we are."""
        self._link.send(GREETING)

    def measure(self) -> Measurement:
        """The newest measurement that has come."""
        datagrams, dropped = self._link.receive(MOST)
        if dropped:
            self.counts.note("link", "flood", dropped)
        for datagram in datagrams:
            try:
                self._take(datagram)
            except RefusedMessageError as refused:
                self.counts.note("link", str(refused))
        if self.heard is not None and self._settling:
            self._settling -= 1
        while self._delays and self._delays[0][0] < self._now() - DELAY_OVER:
            self._delays.popleft()
        self.loop_delay = min((delay for _, delay in self._delays), default=0.0)
        self._taken(self._stamps.taken)
        older = self._now() - self._stamps.taken
        return self._measured._replace(capture_age=self._measured.capture_age + older)

    def _take(self, datagram: Datagram) -> None:
        if datagram.stranger:
            raise RefusedMessageError("not from the robot that was named")
        message = decode(datagram.data, StateMessage)
        measurement, now = self._names.measurement(message), self._now()
        if self._imu and measurement.imu is None:
            raise RefusedMessageError("no imu")
        if not self._speaker.hears(datagram.sender, now):
            raise RefusedMessageError("second sender")
        if self._settling:
            self._first = min(self._first, now - message.stamp)
        before, self._speaker = self._speaker, self._speaker.after(datagram.sender, now)
        if self._speaker.changes > before.changes:
            self.counts.note("link", ANOTHER, why=f"{datagram.sender} in place of {before.sender}")
            self._stamps = Stamps(taken=self._stamps.taken)  # another clock
            self._delays.clear()
        self.heard = message
        if message.loop_delay is not None and 0.0 <= message.loop_delay < math.inf:
            self._delays.append((now, message.loop_delay))
        self._stamps, fault = judged(self._stamps, message.stamp, now)
        if believed(fault):
            self._measured = measurement if self._imu else measurement._replace(imu=ABSENT)
        if fault:
            raise RefusedMessageError(fault)

    def record(self, measurement: Measurement, command: Command) -> np.ndarray:
        """Measurement and command, flat."""
        return np.hstack([*measurement.entries, *command])

    def apply(self, command: Command) -> None:
        """Send the command; the clock says when the next tick is due."""
        stamp = 0.0 if self.heard is None else self._stamps.stamp
        self._link.send(encode(self._names.command_message(self._sent, stamp, command)))
        self._sent += 1

    def fault(self) -> str:
        """None: the guard knows what to do with whatever comes."""
        return ""
