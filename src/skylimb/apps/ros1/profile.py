"""What a node can be: the topics of each profile, and what the loop asks of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from typing import NamedTuple, Protocol

from skylimb.analysis.exchange import lab_topics as topics
from skylimb.analysis.exchange.lab_topics import Topic
from skylimb.analysis.recording.run import Run
from skylimb.apps.ros1.messages import Arrived, Outgoing
from skylimb.apps.ros1.tick import Tick

PROFILES = ("simulator", "controller", "both")


class PendingRun(NamedTuple):
    """A flight or mission to keep: its name, and what makes its run, which takes too long for a tick."""

    name: str
    run: Callable[[], Run]


class Profile(Protocol):
    """What a node is.

    Attributes:
        last: the last tick; None of a profile without a pilot, or before the first one.
        kept: flights and missions so far.
    """

    @property
    def faults(self) -> Counter[str]:
        """How often each fault was met."""
        ...

    @property
    def over(self) -> str:
        """Why it cannot go on; empty while it can."""
        ...

    last: Tick | None
    kept: list[PendingRun]

    def tick(self, arrived: Iterable[Arrived], stamp: float) -> list[Outgoing]:
        """One tick; `stamp` is the time of the messages' clock, s."""
        ...

    def close(self) -> None:
        """Keep what is under way."""
        ...


class ProfileTopics(NamedTuple):
    """Topics that a profile subscribes to, and those that it publishes."""

    subscribed: tuple[Topic, ...]
    published: tuple[Topic, ...]


def profile_topics(profile: str, servos: bool = False) -> ProfileTopics:
    """The topics of a profile.

    Args:
        profile: one of `PROFILES`.
        servos: whether it speaks with the servos in their own counts. Then nobody need translate for
            `controller`, and for `simulator` the lab's `servo_bridge` does.
    """
    sensors = (topics.MOCAP, topics.IMU)
    board = tuple(topic for topic in topics.ACTUATORS if topic.type.startswith("spinal"))
    board = tuple(topic for topic in board if topic is not topics.SERVO_TARGETS)
    if profile == "both":
        commands = (topics.FOUR_AXES, topics.GIMBALS_CTRL, topics.CONFIG)
        robot = (*sensors, topics.JOINT_STATES, *commands)
        return ProfileTopics((*topics.USER, topics.BATTERY), (*robot, *topics.VIEWS))
    states, targets = (topics.JOINT_STATES,), (topics.JOINTS_CTRL, topics.GIMBALS_CTRL)
    if servos:
        states, targets = (topics.SERVO_STATES,), (topics.SERVO_TARGETS,)
    robot = (*sensors, *states, topics.ACK, topics.BATTERY)
    if profile == "simulator":
        return ProfileTopics((*board, *targets), (*robot, topics.DIAGNOSTICS))
    more = (topics.JOINT_STATES,) if servos else ()
    return ProfileTopics((*topics.USER, *robot), (*board, *targets, *more, *topics.VIEWS))
