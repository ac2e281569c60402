"""What comes from the topics and goes to them, with its topic."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from skylimb.analysis.exchange.lab_ticks import TickView
from skylimb.analysis.exchange.lab_topics import Topic, is_due


class Arrived(NamedTuple):
    """A message that has come.

    Attributes:
        topic: without the namespace.
        value: a plain message, number or word; None for one without content.
        sender: who published it.
        at: when it came, the pacer's time, s.
    """

    topic: str
    value: Any
    sender: str
    at: float


class Outgoing(NamedTuple):
    """A message that is to be published."""

    topic: Topic
    value: Any


def published(topics: Iterable[Topic], tick: TickView, k: int, period: float) -> Iterator[Outgoing]:
    """The messages of a tick on those of some topics that are due at it.

    Args:
        topics: those without a `make` are left to whoever makes their messages.
        tick: what it holds.
        k: its number.
        period: of the ticks, s.
    """
    for topic in topics:
        if topic.make is not None and is_due(topic, k, period):
            value = topic.make(tick)
            if value is not None:
                yield Outgoing(topic, value)
