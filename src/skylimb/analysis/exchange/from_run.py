"""A run as a stream of messages."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from skylimb.analysis.exchange.lab_topics import NAMESPACE, Builder, ticks_of, topics_of
from skylimb.analysis.exchange.own_topics import NUMBERS, ROW, record_messages, row_message, row_table
from skylimb.analysis.exchange.stream import Message
from skylimb.analysis.recording.run import Run
from skylimb.robots.model import Robot

START = 10**9
"""Time of the first row, ns, of a run that has no date; ROS takes 0 for no time."""


def messages_of(
    run: Run, robot: Robot, types: Any, link: str, namespace: str = NAMESPACE, start: int = START
) -> Iterator[Message]:
    """Everything that a run holds, in the order of time.

    Args:
        run: what flew.
        robot: its model.
        types: message classes.
        link: whose pose is on the lab's topics.
        namespace: of the lab's topics.
        start: time of the first row, ns.
    """
    builder = Builder(run.log, robot, types, start, link, namespace)
    for topic, kind, value in record_messages(run, types):
        yield Message(topic, kind, start, value)
    table = row_table(run.log)
    due = [(topic, iter(ticks_of(topic, builder.times))) for topic in topics_of(run.log)]
    nexts = [next(ticks, None) for _, ticks in due]
    for k, time in enumerate(builder.times.tolist()):
        yield Message(ROW, NUMBERS, time, row_message(types, table[k]))
        for i, (topic, ticks) in enumerate(due):
            if nexts[i] != k:
                continue
            nexts[i] = next(ticks, None)
            value = topic.make(builder, k)
            if value is not None:
                yield Message(f"/{namespace}/{topic.name}".replace("//", "/"), topic.type, time, value)
