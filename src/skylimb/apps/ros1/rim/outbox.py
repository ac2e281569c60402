"""Publishers of the topics whose definitions are known; those that are not are named once."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from skylimb.apps.ros1.outputs import Outgoing
from skylimb.apps.ros1.rim.definitions import Definitions
from skylimb.apps.ros1.rim.writing import message_of
from skylimb.apps.ros1.topics import RECORD, ROW, SOURCE, Topic

_log = logging.getLogger(__name__)

_LATCHED = (RECORD, SOURCE)
_QUEUE, _LONG_QUEUE = 10, 10_000


class Outbox:
    """Publishes plain messages.

    Args:
        offered: topics that may be published.
        definitions: of their types.
        namespace: of the lab's topics.
        advertise: makes a publisher of a topic's whole name, a class, its queue's length, and whether it is
            latched.
    """

    def __init__(
        self,
        offered: Sequence[Topic],
        definitions: Definitions,
        namespace: str,
        advertise: Callable[[str, Any, int, bool], Any],
    ) -> None:
        self._find, self.counts = definitions.find, Counter[str]()
        known = {topic: definitions.find(topic.type) for topic in offered}
        self.unknown = tuple(topic for topic, cls in known.items() if cls is None)
        self._publishers = {
            topic: advertise(
                topic.full(namespace), cls, _LONG_QUEUE if topic == ROW else _QUEUE, topic in _LATCHED
            )
            for topic, cls in known.items()
            if cls is not None
        }

    def publish(self, messages: Iterable[Outgoing]) -> None:
        """Publish what somebody listens to; what is latched waits for whoever comes."""
        for topic, value in messages:
            publisher = self._publishers.get(topic)
            if publisher is None or not (topic in _LATCHED or publisher.get_num_connections()):
                continue
            try:
                publisher.publish(message_of(topic, value, self._find))
            except Exception as error:  # of rospy and genpy; what is only looked at must not end a flight
                what = f"cannot publish {topic.name}"
                self.counts[what] += 1
                if self.counts[what] == 1:
                    _log.warning("%s: %s", what, error)
