"""Over real DDS: a foreign type, another quality of service, a second master; the node says each."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from skylimb.analysis.exchange.lab_topics import ORDERS, TARGET_POSE
from skylimb.analysis.exchange.ros2_types import Ros2Types
from skylimb.apps.ros2.connection import Dds
from skylimb.apps.ros2.dds_types import DdsTypes

SECONDS = 90.0


class Said:
    """A node, and what it says."""

    def __init__(self, environment: dict[str, str], log: Path) -> None:
        self._log = log
        words = [sys.executable, "-m", "skylimb", "ros2", "both", "--controller", "hybrid"]
        with log.open("wb") as out:
            self.process = subprocess.Popen(words, env=environment, stdout=out, stderr=subprocess.STDOUT)

    def wait(self, words: str, meanwhile: Any = lambda: None) -> None:
        end = time.monotonic() + SECONDS
        while words not in (text := self._log.read_text(encoding="utf-8")):
            assert time.monotonic() < end, f"{words!r} is not in\n{text}"
            meanwhile()
            time.sleep(0.2)


@pytest.fixture
def node(domain: dict[str, str], tmp_path: Path) -> Iterator[Said]:
    said = Said(domain, tmp_path / "node.log")
    yield said
    said.process.terminate()
    said.process.wait(60)


@pytest.mark.slow
def test_whoever_disturbs_is_named(node: Said) -> None:
    from cyclonedds.pub import DataWriter
    from cyclonedds.qos import Policy, Qos
    from cyclonedds.topic import Topic

    node.wait("below /skylimb")
    second = Dds("both", [], "skylimb", False, False)
    types, at = DdsTypes(Ros2Types().types), f"rt{TARGET_POSE.full('skylimb')}"
    weak = Qos(Policy.Reliability.BestEffort)
    participant = second._participant
    lazy = DataWriter(participant, Topic(participant, at, types.of(TARGET_POSE.type)), qos=weak)
    node.wait("fault: publisher with another QoS on target_pose")
    foreign = DataWriter(participant, Topic(participant, at, types.of("std_msgs/msg/String")))
    node.wait(f"fault: foreign type on /skylimb/target_pose: {foreign.topic.typename}")
    start = second._advertise(ORDERS[0].full("skylimb"), None, 10, False)
    node.wait("start is refused", lambda: start.publish(Ros2Types().write(ORDERS[0].type, None, 0)))
    node.wait("participant")
    assert lazy.topic.typename == "geometry_msgs::msg::dds_::PoseStamped_"
