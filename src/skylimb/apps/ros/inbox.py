"""Subscribers that keep raw messages until the loop takes them: nothing that is sent can stop the loop.

Whatever comes is kept as bytes, the newest few of each topic. Digests are checked, and bytes read, when the
loop takes them. So a flood costs no more than its newest messages, and a wrong digest is counted and said
instead of being refused in silence.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from skylimb.analysis.exchange.lab_topics import Topic
from skylimb.analysis.exchange.message_types import Types
from skylimb.apps.ros.messages import Arrived
from skylimb.flight.realtime.faults import Faults

MOST = 32
"""Messages of a topic that are kept between two ticks, the newest."""

LONGEST = 1_000_000
"""Bytes of a message at most; a longer one is none of the lab's."""


class Raw(NamedTuple):
    """A message as it came."""

    data: bytes
    md5: str
    kind: str
    sender: str
    at: float


class Inbox:
    """Subscribes to topics, and hands over what has come.

    Args:
        subscribed: topics to listen to; those of unknown types are left out.
        definitions: of their types.
        namespace: of the lab's topics.
        clock: the loop's time, s.
        subscribe: makes a subscriber of a whole topic name and a callback with a raw message.
        name: our own, whose messages are not taken.
    """

    def __init__(
        self,
        subscribed: Sequence[Topic],
        definitions: Types,
        namespace: str,
        clock: Callable[[], float],
        subscribe: Callable[[str, Callable[[Raw], None]], Any],
        name: str = "",
    ) -> None:
        known = [topic for topic in subscribed if definitions.knows(topic.type)]
        self._definitions = definitions
        self._digests = {topic: definitions.described(topic.type)[1] for topic in known}
        self._waiting: dict[Topic, deque[Raw]] = {topic: deque(maxlen=MOST) for topic in known}
        self._clock, self._name = clock, name
        self.counts = Faults()
        self._subscribers = [
            subscribe(topic.full(namespace), lambda raw, topic=topic: self._keep(topic, raw))
            for topic in known
        ]

    def _keep(self, topic: Topic, raw: Raw) -> None:
        """In a thread of the middleware's own: one test, one append."""
        if raw.sender == self._name:
            return
        waiting = self._waiting[topic]
        if len(waiting) == MOST:
            self.counts.note("inbox", f"flood of {topic.name}")
        waiting.append(raw._replace(at=self._clock()))

    def take(self) -> list[Arrived]:
        """All that has come and could be read, topic by topic."""
        found: list[Arrived] = []
        for topic, waiting in self._waiting.items():
            while waiting:
                arrived = self._read(topic, waiting.popleft())
                if arrived is not None:
                    found.append(arrived)
        return found

    def _read(self, topic: Topic, raw: Raw) -> Arrived | None:
        name = topic.name
        if raw.md5 not in (self._digests[topic], "*"):
            why = f"{raw.sender} sends {raw.kind} {raw.md5}"
            self.counts.note("inbox", f"wrong md5 of {name}", why=why)
        elif len(raw.data) > LONGEST:
            self.counts.note("inbox", f"message too long on {name}", why=f"{len(raw.data)} bytes")
        else:
            try:
                value = self._definitions.read(topic.type, raw.data)
            except Exception as error:  # rosbags raises what its struct calls raise
                self.counts.note("inbox", f"unreadable message on {name}", why=str(error))
            else:
                return Arrived(name, value, raw.sender, raw.at)
        return None
