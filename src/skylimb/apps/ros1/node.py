"""A profile's tick on the wall clock, between what arrives and what is published."""

from __future__ import annotations

import signal
import time
from collections import Counter
from collections.abc import Callable, Iterable
from typing import Any, Protocol

import numpy as np

from skylimb.apps.ros1.desk import Arrived
from skylimb.apps.ros1.outputs import Outgoing, diagnosis
from skylimb.apps.ros1.tick import Tick
from skylimb.apps.ros1.topics import DIAGNOSTICS
from skylimb.flight.guarded import without_garbage
from skylimb.flight.realtime.pacer import Pacer
from skylimb.flight.realtime.timing import Timing
from skylimb.simulation.engine_timer import without_timer

_ONCE = 1.0
"""Seconds before the same line is said again."""

_LAND = "teleop_command/land"


class Profile(Protocol):
    """What a node is."""

    @property
    def faults(self) -> Counter[str]:
        """How often each fault was met."""
        ...

    @property
    def over(self) -> str:
        """Why it cannot go on; empty while it can."""
        ...

    @property
    def last(self) -> Tick | None:
        """The last tick; None of a profile without a pilot, or before the first one."""
        ...

    def tick(self, arrived: Iterable[Arrived], stamp: float) -> list[Outgoing]:
        """One tick; `stamp` is the time of the messages' clock, s."""
        ...

    def close(self) -> None:
        """Keep what is under way."""
        ...


class Carrier(Protocol):
    """Carries messages to a middleware and back, and never waits."""

    @property
    def closed(self) -> bool:
        """Whether the middleware is gone."""
        ...

    def take(self) -> list[Arrived]:
        """What has come; `at` is the monotonic clock's."""
        ...

    def carry(self, messages: list[Outgoing]) -> None:
        """Publish these."""
        ...

    def faults(self) -> Counter[str]:
        """How often each fault was met on the way."""
        ...


class Node:
    """A profile on the wall clock.

    Args:
        profile: what it is.
        carrier: to the middleware.
        pacer: of the ticks.
        say: is handed what people are to read.
        clock: of the messages' stamps, s.
    """

    def __init__(
        self,
        profile: Profile,
        carrier: Carrier,
        pacer: Pacer,
        say: Callable[[str], None] = print,
        clock: Callable[[], float] = time.time,
    ) -> None:
        self._profile, self._carrier, self._pacer = profile, carrier, pacer
        self._say, self._clock = say, clock
        self._to_end = 0
        self._known: Counter[str] = Counter()
        self._told: dict[str, float] = {}
        self._late: list[float] = []
        self._took: list[float] = []

    @property
    def timing(self) -> Timing:
        """How the loop kept to the clock; latency until all of a tick was handed over."""
        late = np.array(self._late)
        return Timing(self._pacer.period, late, np.array(self._took), np.zeros(len(late), dtype=bool))

    @property
    def faults(self) -> Counter[str]:
        """How often each fault was met, by the profile and on the way."""
        return self._profile.faults + self._carrier.faults()

    def spin(self) -> None:
        """Tick until there is nobody to talk to; Ctrl-C lands first, a second one ends it."""
        before = signal.signal(signal.SIGINT, self._interrupted)
        try:
            with without_timer(), without_garbage():
                self._pacer.start(self._pacer.period)
                k = 0
                while not self._done():
                    self._late.append(self._pacer.wait(k))
                    self._carrier.carry(self._profile.tick(self._arrived(), self._clock()))
                    k += 1
                    if k % round(1.0 / self._pacer.period) == 0:
                        self._diagnose()
                    self._tell()
                    self._took.append(self._pacer.elapsed())
        finally:
            signal.signal(signal.SIGINT, before)
            self._profile.close()
        gone = "" if self._to_end or not self._carrier.closed else "the middleware's process is gone"
        if self._profile.over or gone:
            self._say(self._profile.over or gone)

    def _arrived(self) -> list[Arrived]:
        started = self._pacer.started
        arrived = [one._replace(at=one.at - started) for one in self._carrier.take()]
        if self._to_end:
            arrived.append(Arrived(_LAND, None, "Ctrl-C", self._pacer.time()))
        return arrived

    def _interrupted(self, *ignored: Any) -> None:
        self._to_end += 1

    def _done(self) -> bool:
        last = self._profile.last
        stands = last is None or not last.motors
        asked = self._to_end > 1 or (self._to_end == 1 and stands)
        return asked or self._carrier.closed or bool(self._profile.over)

    def _diagnose(self) -> None:
        faults, last = self.faults, self._profile.last
        news = faults - self._known
        for name in sorted(name for name in news if not self._known[name]):
            self._say(f"fault: {name}")
        self._known = faults
        if last is not None:
            late = float(np.quantile(self._late[-200:], 0.99))
            more = {"tick_late_p99_ms": f"{1e3 * late:.3f}"}
            self._carrier.carry([Outgoing(DIAGNOSTICS, diagnosis(last, faults, news, more))])

    def _tell(self) -> None:
        last = self._profile.last
        now = self._pacer.time()
        for words in last.said if last is not None else ():
            # Whoever orders the same again and again is answered once a second.
            if now - self._told.get(words, -np.inf) >= _ONCE:
                self._told[words] = now
                self._say(words)
