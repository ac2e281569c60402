"""ROS 2 in its own process: DDS readers and writers, and no flight."""

from __future__ import annotations

import logging
import os
import time
from collections import Counter
from collections.abc import Callable, Iterable
from typing import Any

from skylimb.analysis.exchange.lab_topics import IMU, MOCAP, ORDERS, Topic
from skylimb.analysis.exchange.ros2_types import Ros2Types
from skylimb.apps.ros.answers import ANSWER
from skylimb.apps.ros.inbox import MOST, Inbox, Raw
from skylimb.apps.ros.messages import Arrived
from skylimb.apps.ros.outbox import Outbox
from skylimb.apps.ros2.dds_types import DdsTypes
from skylimb.apps.ros2.dialect import ROS2_DIALECT
from skylimb.apps.ros2.services import PARAMETERS, Services

_log = logging.getLogger(__name__)

_BEST_EFFORT = (MOCAP.name, IMU.name)
"""Sensor data, of which a newer one is worth more than a lost one."""

_LOOPBACK = """
<General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>
<AllowMulticast>false</AllowMulticast></General>
<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>99</MaxAutoParticipantIndex>
<Peers><Peer address="localhost"/></Peers></Discovery>"""
"""This machine alone: what ROS 2 calls the discovery range LOCALHOST."""

_CONFIG = """<CycloneDDS><Domain><Compatibility>
<IgnoreTypeInformation>1.15</IgnoreTypeInformation></Compatibility>{}</Domain></CycloneDDS>"""
"""Fast DDS (1.15) describes arrays in a way that Cyclone cannot read; types are then compared by name."""


def config(anywhere: bool) -> str:
    """Cyclone's configuration: this machine alone, or what the user's environment says."""
    if not anywhere:
        return _CONFIG.format(_LOOPBACK)
    return ",".join(filter(None, (os.environ.get("CYCLONEDDS_URI"), _CONFIG.format(""))))


class Dds:
    """The `Connection` of DDS.

    Args:
        profile: one of `PROFILES`.
        messages: none; ROS 2's types are known.
        namespace: of the topics.
        servos: none are spoken with in their own counts.
        anywhere: whether it may be on a network.
    """

    gone = False

    def __init__(self, profile: str, messages: Any, namespace: str, servos: bool, anywhere: bool) -> None:
        from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication
        from cyclonedds.domain import Domain, DomainParticipant

        number = int(os.environ.get("ROS_DOMAIN_ID") or 0)
        self._domain = Domain(number, config(anywhere))
        self._participant = DomainParticipant(number)
        types, topics = Ros2Types(), ROS2_DIALECT.topics(profile, servos)
        self._types = DdsTypes(types.types)
        self._topics = {one.full(namespace): one for one in (*topics.subscribed, *topics.published)}
        self._readers: dict[Topic, tuple[Any, Callable[[Raw], None]]] = {}
        self._inbox = Inbox(topics.subscribed, types, namespace, time.monotonic, self._subscribe)
        self._outbox = Outbox(topics.published, types, namespace, self._advertise)
        self._services = _services(profile, namespace, topics.subscribed)
        self._commands = {f"rt{topic.full(namespace)}" for topic in topics.commands}
        self._publications = BuiltinDataReader(self._participant, BuiltinTopicDcpsPublication)

    @property
    def faults(self) -> Counter[str]:
        """How often each was met."""
        found = self._inbox.counts + self._outbox.counts
        for topic, (reader, _) in self._readers.items():
            refused = reader.get_requested_incompatible_qos_status().total_count
            found[f"publisher with another QoS on {topic.name}"] = refused
        for one in self._others():
            kind = self._types.of(self._topics[one.topic_name[2:]].type).__idl__.idl_transformed_typename
            if one.type_name != kind:
                found[f"foreign type on {one.topic_name[2:]}: {one.type_name}"] += 1
        return +found

    @property
    def foreign(self) -> tuple[str, ...]:
        """Who else commands the robot."""
        others = (one for one in self._others() if one.topic_name in self._commands)
        return tuple(f"participant {one.participant_key} on {one.topic_name[2:]}" for one in others)

    def publish(self, messages: Iterable[tuple[str, Any]]) -> None:
        """Publish messages by the names of their topics; those of no topic are for the services."""
        messages = list(messages)
        self._outbox.publish(messages)
        for name, value in messages:
            if self._services is not None and name == ANSWER.name:
                self._services.calls.answer(*value)
            elif self._services is not None and name == PARAMETERS.name:
                self._services.declare(value)

    def take(self) -> list[Arrived]:
        """What has come."""
        for reader, keep in self._readers.values():
            for message in reader.take(MOST):
                if message.sample_info.valid_data:
                    sender = str(message.sample_info.publication_handle)
                    keep(Raw(message.content, "*", "", sender, 0.0))
        return [*self._inbox.take(), *(self._services.calls.take() if self._services is not None else ())]

    def close(self) -> None:
        """Leave: what DDS holds goes with the process."""

    def _others(self) -> list[Any]:
        """Publications of other participants on our topics."""
        return [
            one
            for one in self._publications.read(1000)
            if (one.topic_name or "").removeprefix("rt") in self._topics
            and one.participant_key != self._participant.guid
        ]

    def _subscribe(self, name: str, keep: Callable[[Raw], None]) -> None:
        from cyclonedds.sub import DataReader

        topic = self._topics[name]
        self._readers[topic] = DataReader(self._participant, self._topic(name), _qos(topic, MOST)), keep

    def _advertise(self, name: str, described: Any, queue: int, latch: bool) -> _Writer:
        return _Writer(self._participant, self._topic(name), _qos(self._topics[name], queue))

    def _topic(self, name: str) -> Any:
        from cyclonedds.topic import Topic as DdsTopic

        return DdsTopic(self._participant, f"rt{name}", self._types.of(self._topics[name].type))


def _qos(topic: Topic, depth: int) -> Any:
    """Quality of service by what a topic is: sensor data, latched, or all else."""
    from cyclonedds.qos import Policy, Qos
    from cyclonedds.util import duration

    reliable = Policy.Reliability.Reliable(duration(milliseconds=10))
    return Qos(
        Policy.Reliability.BestEffort if topic.name in _BEST_EFFORT else reliable,
        Policy.Durability.TransientLocal if topic.latched else Policy.Durability.Volatile,
        Policy.History.KeepLast(1 if topic.latched else depth),
        Policy.DataRepresentation(use_cdrv0_representation=True),
        Policy.IgnoreLocal.Participant,  # a user's joints_ctrl and ours are one topic
    )


def _services(profile: str, namespace: str, subscribed: Iterable[Topic]) -> Services | None:
    """Services, where rclpy is."""
    try:
        return Services(profile, namespace, [topic for topic in subscribed if topic in ORDERS])
    except ImportError:
        _log.warning("no services: rclpy is not there (a ROS 2 that is sourced has it); topics do the same")
        return None


class _Writer:
    """A writer of serialized messages."""

    def __init__(self, participant: Any, topic: Any, qos: Any) -> None:
        from cyclonedds.pub import DataWriter

        self._writer, self._kind = DataWriter(participant, topic, qos=qos), topic.data_type

    def publish(self, data: bytes) -> None:
        message = self._kind()
        message.content = data
        self._writer.write(message)

    def get_num_connections(self) -> int:
        return self._writer.get_publication_matched_status().current_count
