"""The process that speaks ROS: subscribers and publishers, and no flight.

rospy has a thread for every connection. In the flight's own process, which has none, they would take
turns with its ticks.

    python -m skylimb.apps.ros1.bridge FD GIVEN
"""

from __future__ import annotations

import json
import select
import signal
import socket
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from skylimb.analysis.exchange.lab_topics import FOREIGN
from skylimb.analysis.exchange.message_types import Definitions
from skylimb.apps.ros1.bridge.inbox import Inbox, Raw
from skylimb.apps.ros1.bridge.installation import require_ros
from skylimb.apps.ros1.bridge.master import MasterWatch
from skylimb.apps.ros1.bridge.outbox import Outbox
from skylimb.apps.ros1.bridge.pipe import Pipe
from skylimb.apps.ros1.messages import Arrived, Outgoing
from skylimb.apps.ros1.profile import profile_topics

_PATIENCE = 0.001
"""Seconds after which subscribers are looked at, though the flight has nothing to say."""

_EVERY = 1.0
"""Seconds between two counts of faults that are sent to the flight."""


_END = 10.0
"""Seconds that the process has to end."""


class Bridge:
    """The flight's end of the bridge, whose process it starts; it never waits for it.

    Args:
        profile: one of `PROFILES`.
        messages: folders of .msg files.
        namespace: of the lab's topics.
        servos: whether it speaks with the servos in their own counts.

    Attributes:
        faults: how often each was met there, and on the way.
    """

    def __init__(self, profile: str, messages: Sequence[str], namespace: str, servos: bool) -> None:
        near, far = socket.socketpair()
        given = json.dumps([profile, list(messages), namespace, servos])
        words = [sys.executable, "-m", __package__ or "", str(far.fileno()), given]
        self._process = subprocess.Popen(words, pass_fds=[far.fileno()])
        far.close()
        self._pipe, self._faults = Pipe(near), Counter[str]()

    @property
    def closed(self) -> bool:
        """Whether ROS, or its process, is gone."""
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


def bridge(pipe: Pipe, profile: str, messages: Sequence[str], namespace: str, servos: bool) -> None:
    """Carry messages until ROS shuts down or the flight's process is gone."""
    import rospy

    rospy.init_node(f"skylimb_{profile}", disable_signals=True)
    definitions, topics = Definitions(messages), profile_topics(profile, servos)
    inbox = Inbox(topics.subscribed, definitions, namespace, time.monotonic, _subscribe, rospy.get_name())
    outbox = Outbox(topics.published, definitions, namespace, _Publisher)
    commands, due = {topic.full(namespace) for topic in topics.commands}, time.monotonic()
    master = MasterWatch(commands, rospy.get_name())
    while not rospy.is_shutdown() and not pipe.closed:
        select.select([pipe], [], [], _PATIENCE)
        for batch in pipe.receive():
            outbox.publish(batch)
        arrived = inbox.take()
        if arrived:
            pipe.send(arrived)
        if time.monotonic() > due:
            due += _EVERY
            gone = Counter({"master is gone": master.gone}) if master.gone else Counter[str]()
            pipe.send(inbox.counts + outbox.counts + gone)
            if master.foreign is not None:
                pipe.send([Arrived(FOREIGN, master.foreign, "", time.monotonic())])
    pipe.close()
    master.close()
    rospy.signal_shutdown("done")


def _subscribe(name: str, take: Callable[[Raw], None]) -> Any:
    import rospy

    def callback(message: Any) -> None:
        header = message._connection_header
        md5, kind, sender = (str(header.get(key, "")) for key in ("md5sum", "type", "callerid"))
        take(Raw(message._buff, md5, kind, sender, 0.0))

    return rospy.Subscriber(name, rospy.AnyMsg, callback, queue_size=100, tcp_nodelay=True)


class _Publisher:
    """A publisher of serialized messages; rospy has only subscribers of them."""

    def __init__(self, name: str, described: tuple[str, str, str], queue: int, latch: bool) -> None:
        import rospy

        names = ("_type", "_md5sum", "_full_text")
        self._cls: Any = type("Serialized", (rospy.AnyMsg,), dict(zip(names, described, strict=True)))
        self._publisher = rospy.Publisher(name, self._cls, queue_size=queue, latch=latch, tcp_nodelay=True)

    def publish(self, data: bytes) -> None:
        message = self._cls()
        message.deserialize(data)
        self._publisher.publish(message)

    def get_num_connections(self) -> int:
        return self._publisher.get_num_connections()


def main(words: Sequence[str]) -> None:
    """Be the process that a `Bridge` starts; Ctrl-C is left to the flight."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    require_ros()
    bridge(Pipe(socket.socket(fileno=int(words[0]))), *json.loads(words[1]))
