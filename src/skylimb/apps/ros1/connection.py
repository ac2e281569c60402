"""ROS 1 in its own process: rospy's subscribers and publishers, and no flight."""

from __future__ import annotations

import logging
import threading
import time
import xmlrpc.client
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from importlib import import_module
from typing import Any

from skylimb.analysis.exchange.message_types import Definitions
from skylimb.apps.ros.answers import ANSWER, END
from skylimb.apps.ros.asking import Calls
from skylimb.apps.ros.inbox import Inbox, Raw
from skylimb.apps.ros.messages import Arrived
from skylimb.apps.ros.outbox import Outbox
from skylimb.apps.ros.profile import profile_services, profile_topics
from skylimb.apps.ros1.installation import node_name, require_ros
from skylimb.apps.ros1.master import MasterWatch

_log = logging.getLogger(__name__)


class Rospy:
    """The `Connection` of rospy.

    Args:
        profile: one of `PROFILES`.
        messages: folders of .msg files.
        namespace: of the lab's topics.
        servos: whether it speaks with the servos in their own counts.
        anywhere: whether it may be on a network, which the environment tells rospy.
    """

    def __init__(
        self, profile: str, messages: Sequence[str], namespace: str, servos: bool, anywhere: bool
    ) -> None:
        require_ros()
        import rospy

        rospy.init_node(node_name(profile), disable_signals=True)
        definitions, topics, name = Definitions(messages), profile_topics(profile, servos), rospy.get_name()
        self._inbox = Inbox(topics.subscribed, definitions, namespace, time.monotonic, _subscribe, name)
        self._outbox = Outbox(topics.published, definitions, namespace, _Publisher)
        self._calls, self._services, self._closed = Calls(), list[Any](), threading.Event()
        rospy.on_shutdown(self._land)
        for topic in profile_services(profile, servos):
            self._services += _serve(topic.full(namespace), topic.name, self._calls)
        commands = {topic.full(namespace) for topic in topics.commands}
        self._master = MasterWatch(commands, name, self._register)

    def take(self) -> list[Arrived]:
        """What has come."""
        return [*self._inbox.take(), *self._calls.take()]

    def publish(self, messages: Iterable[tuple[str, Any]]) -> None:
        """Publish messages by the names of their topics; answers are for who has called."""
        messages = list(messages)
        self._outbox.publish(messages)
        for name, value in messages:
            if name == ANSWER.name:
                self._calls.answer(*value)

    @property
    def gone(self) -> bool:
        """Whether ROS shuts down."""
        import rospy

        return rospy.is_shutdown()

    @property
    def faults(self) -> Counter[str]:
        """How often each was met."""
        master = {"master is gone": self._master.gone, "master was started anew": self._master.anew}
        return self._inbox.counts + self._outbox.counts + Counter(master)

    @property
    def foreign(self) -> tuple[str, ...] | None:
        """Who else commands the robot."""
        return self._master.foreign

    def close(self) -> None:
        """Leave the master."""
        import rospy

        self._closed.set()
        self._master.close()
        rospy.signal_shutdown("done")

    def _register(self, master: Any) -> None:
        """Tell a master that was started anew of us, as rospy does once; connections that are open stay."""
        import rospy

        name, uri = rospy.get_name(), rospy.get_node_uri()
        node: Any = xmlrpc.client.ServerProxy(uri)
        for topic, kind in node.getSubscriptions(name)[2]:
            node.publisherUpdate(name, topic, master.registerSubscriber(topic, kind, uri))
        for service in self._services:
            master.registerService(service.resolved_name, service.uri, uri)
        for topic, kind in node.getPublications(name)[2]:  # the last, as they show whether it has registered
            master.registerPublisher(topic, kind, uri)

    def _land(self) -> None:
        """Whoever shuts the node down lands it first, as Ctrl-C does; rospy waits for it."""
        if not self._closed.is_set():
            self._calls.add(Arrived(END, None, "shutdown", time.monotonic()))
            self._closed.wait()


def _subscribe(name: str, take: Callable[[Raw], None]) -> Any:
    import rospy

    def callback(message: Any) -> None:
        header = message._connection_header
        md5, kind, sender = (str(header.get(key, "")) for key in ("md5sum", "type", "callerid"))
        take(Raw(message._buff, md5, kind, sender, 0.0))

    return rospy.Subscriber(name, rospy.AnyMsg, callback, queue_size=100, tcp_nodelay=True)


def _serve(name: str, topic: str, calls: Calls) -> list[Any]:
    """A service of the lab's type; none where Debian's `python3-std-srvs` is not."""
    import rospy

    try:
        types: Any = import_module("std_srvs.srv")
    except ImportError:
        _log.warning("no service %s: apt-get install python3-std-srvs", name)
        return []
    return [rospy.Service(name, types.SetBool, lambda asked: calls.ask(topic, bool(asked.data)))]


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
