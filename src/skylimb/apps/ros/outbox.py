"""Publishers of the topics whose types are known."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from skylimb.analysis.exchange.lab_topics import ROW, Topic
from skylimb.analysis.exchange.message_types import Types
from skylimb.flight.realtime.faults import Faults

_QUEUE, _LONG_QUEUE = 10, 10_000


class Outbox:
    """Publishes plain messages.

    Args:
        offered: topics that may be published; those of unknown types are left out.
        definitions: of their types.
        namespace: of the lab's topics.
        advertise: makes a publisher of serialized messages from a topic's whole name, the name, digest and
            text of its type, its queue's length, and whether it is latched.
    """

    def __init__(
        self,
        offered: Sequence[Topic],
        definitions: Types,
        namespace: str,
        advertise: Callable[[str, tuple[str, str, str], int, bool], Any],
    ) -> None:
        self._definitions, self.counts = definitions, Faults()
        self._publishers: dict[str, tuple[Topic, Any]] = {}
        for topic in offered:
            if definitions.knows(topic.type):
                name, described = topic.full(namespace), definitions.described(topic.type)
                queue = _LONG_QUEUE if topic is ROW else _QUEUE
                publisher = advertise(name, described, queue, topic.latched)
                self._publishers[topic.name] = topic, publisher
        self._seq = Counter[str]()

    def publish(self, messages: Iterable[tuple[str, Any]]) -> None:
        """Publish what somebody listens to, by name of topic; what is latched waits for whoever comes."""
        for name, value in messages:
            if name not in self._publishers:
                continue
            topic, publisher = self._publishers[name]
            if not (topic.latched or publisher.get_num_connections()):
                continue
            self._seq[name] += 1
            try:
                publisher.publish(self._definitions.write(topic.type, value, self._seq[name]))
            except Exception as error:  # what is only looked at must not end a flight
                self.counts.note("outbox", f"cannot publish {name}", why=str(error))
