"""A profile's tick on the wall clock, between what arrives and what is published."""

from __future__ import annotations

import time
from collections import Counter, deque
from collections.abc import Callable, Mapping
from itertools import islice
from typing import Any

import numpy as np

from skylimb.analysis.exchange.lab_topics import DIAGNOSTICS
from skylimb.analysis.exchange.recorder import FlightRecorder
from skylimb.apps.ros.answers import END, answers
from skylimb.apps.ros.bridge import Bridge
from skylimb.apps.ros.messages import Arrived, Outgoing
from skylimb.apps.ros.piloted import Piloted
from skylimb.apps.ros.simulated import Simulated
from skylimb.apps.ros.states import FlightState
from skylimb.apps.ros.tick import Tick
from skylimb.base.aside import UNREAD, Words, said_aside
from skylimb.base.interrupts import ENDS, answering, insists, unfrozen
from skylimb.flight.realtime.clocked_flight import without_garbage
from skylimb.flight.realtime.pacer import Pacer
from skylimb.flight.realtime.preflight import Check
from skylimb.flight.realtime.timing import Timing
from skylimb.simulation.engine_timer import without_timer

Profile = Simulated | Piloted
"""What a node is."""

_ONCE = 1.0
"""Seconds before the same line is said again."""

REMEMBERED = 3600.0
"""Seconds for which a node knows how it kept to the clock: it may run for days."""

_LAND = "teleop_command/land"


class Node:
    """A profile on the wall clock.

    Args:
        profile: what it is.
        bridge: to ROS and back; it never waits.
        pacer: of the ticks.
        say: takes what people are to read.
        recorder: keeps flights on the disk as they are flown.

    Attributes:
        broken: why it ended by itself; empty where its user ended it.
    """

    def __init__(
        self,
        profile: Profile,
        bridge: Bridge,
        pacer: Pacer,
        say: Callable[[str], None] = print,
        recorder: FlightRecorder | None = None,
    ) -> None:
        self._profile, self._bridge, self._pacer = profile, bridge, pacer
        self._say, self._recorder = say, recorder
        self._to_end, self.broken = 0, ""
        self._words: Words | None = None
        self._known: Counter[str] = Counter()
        self._last_said: dict[str, float] = {}
        ticks = round(REMEMBERED / pacer.period)
        self._late, self._took = deque[float](maxlen=ticks), deque[float](maxlen=ticks)

    @property
    def timing(self) -> Timing:
        """How the loop kept to the clock in the last hour; latency until all of a tick was sent."""
        late = np.array(self._late)
        return Timing(self._pacer.period, late, np.array(self._took), np.zeros(len(late), dtype=bool))

    @property
    def faults(self) -> Counter[str]:
        """How often each fault was met, by the profile and on the way."""
        kept = Counter[str]() if self._recorder is None else self._recorder.faults
        unread = Counter({} if self._words is None else {UNREAD: self._words.lost})
        return self._profile.faults + self._bridge.faults + kept + unread

    def spin(self) -> None:
        """Tick until there is nobody to talk to; Ctrl-C lands first, a second one ends it.

        So does the end that the system asks for, and a terminal that goes away lands it. Who reads what is
        said holds up no tick.
        """
        with said_aside() as self._words:
            self._spin()

    def _spin(self) -> None:
        try:
            with (
                answering(ENDS, self._interrupted),
                unfrozen(),
                without_timer(),
                without_garbage(),
            ):
                self._pacer.start(self._pacer.period)
                k = 0
                while not self._done():
                    self._late.append(self._pacer.wait(k))
                    arrived = self._arrived()
                    messages = self._profile.tick(arrived, time.time())
                    messages += answers(arrived, self._profile.last)
                    if self._pacer.stood_still(self._profile.caught_up):
                        self._pacer.forgive()
                    self._bridge.carry(messages)
                    if self._recorder is not None:
                        self._recorder.take(messages)
                    k += 1
                    if k % round(1.0 / self._pacer.period) == 0:
                        self._diagnose()
                    self._say_what_happened()
                    self._took.append(self._pacer.elapsed())
        finally:
            self._profile.close()
        last = self._profile.last
        gone = "" if self._to_end or not self._bridge.closed else "the middleware's process is gone"
        if gone and last is not None and last.motors:
            gone += " in flight: nobody commands the robot any more"
        self.broken = self._profile.over or gone
        if self.broken:
            self._say(self.broken)

    def look(self, seconds: float) -> list[Check]:
        """Listen for some seconds, publish nothing, and tell what was looked at."""
        assert isinstance(self._profile, Piloted)
        self._pacer.start(self._pacer.period)
        for k in range(round(seconds / self._pacer.period)):
            self._pacer.wait(k)
            self._profile.tick(self._arrived(), time.time())
        return self._profile.pilot.checks()

    def _arrived(self) -> list[Arrived]:
        started = self._pacer.started
        arrived = [one._replace(at=one.at - started) for one in self._bridge.take()]
        if not self._to_end and any(one.topic == END for one in arrived):
            self._to_end = 1
        if self._to_end:
            arrived.append(Arrived(_LAND, None, "Ctrl-C", self._pacer.time()))
        return arrived

    def _interrupted(self, number: int, *ignored: Any) -> None:
        self._to_end = self._to_end + 1 if insists(number) else max(self._to_end, 1)

    def _done(self) -> bool:
        last = self._profile.last
        stands = last is None or last.flying.state == FlightState.ARM_OFF
        asked = self._to_end > 1 or (self._to_end == 1 and stands)
        return asked or self._bridge.closed or bool(self._profile.over)

    def _diagnose(self) -> None:
        faults, last = self.faults, self._profile.last
        news = faults - self._known
        for name in sorted(name for name in news if not self._known[name]):
            self._say(f"fault: {name}")
        self._known = faults
        if last is not None:
            late = float(np.quantile(list(islice(reversed(self._late), 200)), 0.99))
            message = diagnosis(last, faults, news, f"{1e3 * late:.3f}", time.time())
            self._bridge.carry([Outgoing(DIAGNOSTICS, message)])

    def _say_what_happened(self) -> None:
        last = self._profile.last
        now = self._pacer.time()
        for words in last.said if last is not None else ():
            # Whoever orders the same again and again is answered once a second.
            if now - self._last_said.get(words, -np.inf) >= _ONCE:
                self._last_said[words] = now
                self._say(words)


def diagnosis(
    tick: Tick, faults: Mapping[str, int], news: Mapping[str, int], late: str, stamp: float
) -> dict[str, Any]:
    """How it goes, once a second: fields of a diagnostic array.

    Args:
        tick: the last one.
        faults: all so far, by name.
        news: those of the last second.
        late: the 99th percentile of how late ticks were, ms.
        stamp: s.
    """
    flying = tick.flying
    state = "FORCE_LANDING" if flying.force_landing else flying.state.name
    level, words = 0, state
    if flying.force_landing or flying.low_battery:
        level, words = 2, "force landing" if flying.force_landing else "low battery"
    elif news:
        level, words = 1, ", ".join(f"{name} ({count})" for name, count in sorted(news.items()))
    values = {"flight_state": state, "tick_late_p99_ms": late, **dict(sorted(faults.items()))}
    entries = [{"key": name, "value": str(value)} for name, value in values.items()]
    status = {"level": level, "name": "skylimb", "message": words, "values": entries}
    return {"header.stamp": stamp, "status": [status]}
