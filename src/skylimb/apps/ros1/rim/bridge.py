"""The process that speaks ROS: subscribers and publishers, and no flight.

rospy has a thread for every connection. In the flight's own process, which has none, they would take
turns with its ticks.

    python -m skylimb.apps.ros1.rim FD SETTINGS
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
from dataclasses import asdict, dataclass
from typing import Any

from skylimb.apps.ros1.rim.definitions import Definitions
from skylimb.apps.ros1.rim.here import require_ros
from skylimb.apps.ros1.rim.inbox import Inbox, Raw
from skylimb.apps.ros1.rim.master import MasterWatch
from skylimb.apps.ros1.rim.outbox import Outbox
from skylimb.apps.ros1.rim.pipe import Pipe
from skylimb.apps.ros1.topics import spoken

_PATIENCE = 0.001
"""Seconds after which subscribers are looked at, though the flight has nothing to say."""

_EVERY = 1.0
"""Seconds between two counts of faults that the flight is told."""


@dataclass(frozen=True)
class Faults:
    """How often each fault was met here, so far."""

    counts: dict[str, int]


@dataclass(frozen=True)
class Settings:
    """What the bridge is told at its start; see `ros1.rim.run.Options`."""

    profile: str
    messages: tuple[str, ...]
    namespace: str
    servos: bool = False


def start_bridge(settings: Settings) -> tuple[subprocess.Popen[bytes], Pipe]:
    """The process, and our end of the pipe to it."""
    near, far = socket.socketpair()
    words = [sys.executable, "-m", __package__ or "", str(far.fileno()), json.dumps(asdict(settings))]
    process = subprocess.Popen(words, pass_fds=[far.fileno()])
    far.close()
    return process, Pipe(near)


def bridge(pipe: Pipe, settings: Settings) -> None:
    """Carry messages until ROS shuts down or the flight's process is gone."""
    import rospy

    rospy.init_node(f"skylimb_{settings.profile}", disable_signals=True)
    definitions, topics = Definitions(settings.messages), spoken(settings.profile, settings.servos)
    inbox = Inbox(
        topics.listens,
        definitions,
        settings.namespace,
        time.monotonic,
        _subscribe,
        rospy.get_name(),
    )
    outbox = Outbox(topics.says, definitions, settings.namespace, _advertise)
    master, due = MasterWatch(), time.monotonic()
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
            pipe.send(Faults(dict(inbox.counts + outbox.counts + gone)))
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


def _advertise(name: str, cls: Any, queue: int, latch: bool) -> Any:
    import rospy

    return rospy.Publisher(name, cls, queue_size=queue, latch=latch, tcp_nodelay=True)


def main(words: Sequence[str]) -> None:
    """Be the bridge that `start_bridge` starts; Ctrl-C is the flight's affair."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    require_ros()
    told = json.loads(words[1])
    settings = Settings(told["profile"], tuple(told["messages"]), told["namespace"], told["servos"])
    bridge(Pipe(socket.socket(fileno=int(words[0]))), settings)
