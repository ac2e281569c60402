"""Between the flight's process and that of its middleware: neither waits for the other.

A middleware has threads of its own. In the flight's process, which has none, they would take turns with its
ticks.

    python -m PACKAGE FD GIVEN
"""

from __future__ import annotations

import json
import select
import socket
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from skylimb.analysis.exchange.lab_topics import FOREIGN, Topic
from skylimb.apps.ros.messages import Arrived, Outgoing
from skylimb.apps.ros.pipe import Pipe
from skylimb.apps.ros.profile import LAB, Dialect, ProfileTopics
from skylimb.base.interrupts import ENDS, FREEZES, ignore
from skylimb.flight.plan import FlightPlan

_PATIENCE = 0.001
"""Seconds after which subscribers are looked at, though the flight has nothing to say."""

_EVERY = 1.0
"""Seconds between two counts of faults that are sent to the flight."""

_END = 10.0
"""Seconds that the process has to end."""


@dataclass(frozen=True)
class Middleware:
    """A middleware, as a node is started on it.

    Attributes:
        name: for people.
        package: of its process.
        require: raises where it is not installed, or, unless it may be anywhere, not on this machine alone.
        reach: raises where nobody answers, or another node is what this one would be: of a profile, its
            topics and their namespace.
        say_left_out: says of a profile, its topics and folders of .msg files what is not spoken.
        described_mass: of the robot that is described to all in a namespace, kg; None where none is.
        by_clock: whether nodes live by `/clock`.
        dialect: how a node speaks on it.
        opening: what is said once, of a plan.
    """

    name: str
    package: str
    require: Callable[[bool], None]
    reach: Callable[[str, ProfileTopics, str], None] = lambda profile, topics, namespace: None
    say_left_out: Callable[[str, Sequence[Topic], Sequence[str], Callable[[str], None]], None] = (
        lambda profile, topics, messages, say: None
    )
    described_mass: Callable[[str], float | None] = lambda namespace: None
    by_clock: Callable[[], bool] = lambda: False
    dialect: Dialect = LAB
    opening: Callable[[FlightPlan], list[Outgoing]] = lambda plan: []


class Connection(Protocol):
    """A middleware in its own process."""

    @property
    def gone(self) -> bool:
        """Whether it has shut down."""
        ...

    @property
    def faults(self) -> Counter[str]:
        """How often each was met."""
        ...

    @property
    def foreign(self) -> tuple[str, ...] | None:
        """Who else commands the robot; None before anybody has looked."""
        ...

    def publish(self, messages: Iterable[tuple[str, Any]]) -> None:
        """Publish messages by the names of their topics."""
        ...

    def take(self) -> list[Arrived]:
        """What has come; it never waits."""
        ...

    def close(self) -> None:
        """Leave."""
        ...


class Bridge:
    """The flight's end, which starts the other one's process; it never waits for it.

    Args:
        package: of that process.
        given: what its `main` is given behind the pipe, as JSON takes it.

    Attributes:
        faults: how often each was met there, and on the way.
    """

    def __init__(self, package: str, *given: Any) -> None:
        near, far = socket.socketpair()
        words = [sys.executable, "-m", package, str(far.fileno()), json.dumps(given)]
        self._process = subprocess.Popen(words, pass_fds=[far.fileno()])
        far.close()
        self._pipe, self._faults = Pipe(near), Counter[str]()

    @property
    def closed(self) -> bool:
        """Whether the middleware, or its process, is gone."""
        return self._pipe.closed

    @property
    def faults(self) -> Counter[str]:
        """How often each fault was met there, and what was lost on the way."""
        return self._faults + Counter({"lost on the way to ROS": self._pipe.lost})

    def take(self) -> list[Arrived]:
        """What has come; `at` is the monotonic clock's."""
        found: list[Arrived] = []
        for batch in self._pipe.receive():
            if isinstance(batch, Counter):
                self._faults = batch
            else:
                found += batch
        return found

    def carry(self, messages: list[Outgoing]) -> None:
        """Publish these."""
        if messages:
            self._pipe.send([(one.topic.name, one.value) for one in messages])

    def close(self) -> None:
        """End the process."""
        self._pipe.close()
        self._process.wait(_END)


def main(words: Sequence[str], connect: Callable[..., Connection]) -> None:
    """Be the process that a `Bridge` starts, until either end is gone; signals are left to the flight."""
    ignore((*ENDS, *FREEZES))
    pipe, middleware = Pipe(socket.socket(fileno=int(words[0]))), connect(*json.loads(words[1]))
    due = time.monotonic()
    while not middleware.gone and not pipe.closed:
        select.select([pipe], [], [], _PATIENCE)
        for batch in pipe.receive():
            middleware.publish(batch)
        if arrived := middleware.take():
            pipe.send(arrived)
        if time.monotonic() > due:
            due += _EVERY
            pipe.send(middleware.faults)
            if middleware.foreign is not None:
                pipe.send([Arrived(FOREIGN, middleware.foreign, "", time.monotonic())])
    pipe.close()
    middleware.close()
