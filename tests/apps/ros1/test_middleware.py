"""What ROS 1's middleware says before a node begins, and what it does when ROS ends it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
import xmlrpc.client
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from ros1_master import started_master
from skylimb.analysis.exchange.lab_topics import Topic
from skylimb.apps.ros.answers import END
from skylimb.apps.ros.bridge import Bridge
from skylimb.apps.ros.profile import PROFILES
from skylimb.apps.ros1.middleware import say_left_out
from skylimb.base.errors import ConfigError


@pytest.mark.parametrize("profile", PROFILES)
def test_only_the_profile_without_a_robot_does_without_unknown_types(profile: str) -> None:
    known, unknown = Topic("joints", "sensor_msgs/msg/JointState"), Topic("odd", "lab/msg/Odd")
    said: list[str] = []
    say_left_out(profile, (known,), (), said.append)
    assert said == []
    if profile == "both":
        say_left_out(profile, (known, unknown), (), said.append)
        assert said == ["left out: odd, as no definition of lab/Odd is known (--messages)"]
    else:
        with pytest.raises(ConfigError, match=r"^no definition of lab/Odd: name the robot"):
            say_left_out(profile, (known, unknown), (), said.append)


MESSAGES = Path(__file__).parents[2] / "analysis" / "exchange" / "messages"


class Heard:
    """A node of the profile `both`, and the topics on which something came."""

    def __init__(self, master: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> None:
        for name, value in master.items():
            monkeypatch.setenv(name, value)
        self.bridge = Bridge("skylimb.apps.ros1", "both", [str(MESSAGES)], "hydrus_xi", False, False)
        self.topics: set[str] = set()

    def until(self, done: Callable[[], bool]) -> None:
        """Take what comes until something is so."""
        end = time.monotonic() + 30.0
        while not done() and time.monotonic() < end:
            self.topics.update(one.topic for one in self.bridge.take())
            time.sleep(0.02)
        assert done(), (self.topics, self.bridge.faults)


def test_who_shuts_a_node_down_lands_it_first(
    master: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As `rosnode kill` does, and the master where another node takes the name."""
    import rosgraph

    node = Heard(master, monkeypatch)
    bridge, seen, until = node.bridge, node.topics, node.until
    with ThreadPoolExecutor(1) as other:
        try:
            until(lambda: "skylimb/foreign" in seen)  # it runs
            server = xmlrpc.client.ServerProxy(rosgraph.Master("/test").lookupNode("/skylimb_both"))
            answer = other.submit(server.shutdown, "/test", "user request")
            until(lambda: END in seen)
            seen.clear()
            until(lambda: "skylimb/foreign" in seen)  # it goes on, until the flight has landed
            assert not bridge.closed
            assert not answer.done()
        finally:
            bridge.close()


HALT = """
import time
from skylimb.apps.ros1.installation import require_ros
require_ros()
import rospy
from std_msgs.msg import Empty
rospy.init_node("kill_switch", disable_signals=True)
halt = rospy.Publisher("/hydrus_xi/teleop_command/halt", Empty, queue_size=1)
end = time.monotonic() + 30.0
while time.monotonic() < end:
    halt.publish()
    time.sleep(0.05)
"""
"""Somebody who connects anew, and stops the motors."""


def test_a_kill_switch_that_connects_to_a_new_master_is_heard(
    master: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    node = Heard(master, monkeypatch)
    bridge, seen, until = node.bridge, node.topics, node.until
    others: list[subprocess.Popen[bytes]] = []

    try:
        until(lambda: "skylimb/foreign" in seen)  # it runs
        os.kill(int(master["MASTER_PID"]), signal.SIGKILL)
        until(lambda: bridge.faults["master is gone"] > 0)
        others.append(started_master(master))
        others.append(subprocess.Popen([sys.executable, "-c", HALT], env=master))
        until(lambda: "teleop_command/halt" in seen)
        until(lambda: bridge.faults["master was started anew"] > 0)
        again: Any = xmlrpc.client.ServerProxy(master["ROS_MASTER_URI"])
        known = again.getSystemState("/test")[2]
        topics, services = [{name for name, nodes in known[k] if "/skylimb_both" in nodes} for k in (0, 2)]
        assert {"/hydrus_xi/flight_state", "/diagnostics"} <= topics
        # Debian has the service's type in a package of its own, without which there is none.
        assert ("/hydrus_xi/joints/torque_enable" in services) == (find_spec("std_srvs") is not None)
        assert bridge.faults["master was started anew"] == 1
    finally:
        bridge.close()
        for one in others[::-1]:
            one.kill()
            one.wait()
