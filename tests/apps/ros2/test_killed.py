"""The controller is killed in flight and begins anew, over real DDS: it lands the robot that flies."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from skylimb.analysis.exchange.lab_topics import ORDERS, STATE
from skylimb.analysis.exchange.ros2_types import Ros2Types
from skylimb.apps.ros.states import FlightState
from skylimb.apps.ros2.connection import config
from skylimb.apps.ros2.dds_types import DdsTypes

TYPES = Ros2Types()


class User:
    """Orders, and sees the flight's state."""

    def __init__(self) -> None:
        from cyclonedds.domain import Domain, DomainParticipant
        from cyclonedds.pub import DataWriter
        from cyclonedds.sub import DataReader
        from cyclonedds.topic import Topic

        number, dds = int(os.environ["ROS_DOMAIN_ID"]), DdsTypes(TYPES.types)
        self._domain, self.state = Domain(number, config(False)), -1
        participant = DomainParticipant(number)
        self._empty = dds.of(ORDERS[0].type)
        self._orders = {
            topic.name.rpartition("/")[2]: DataWriter(
                participant, Topic(participant, f"rt{topic.full('skylimb')}", self._empty)
            )
            for topic in ORDERS
        }
        at = Topic(participant, f"rt{STATE.full('skylimb')}", dds.of(STATE.type))
        self._states = DataReader(participant, at)

    def until(self, state: FlightState, order: str = "", seconds: float = 60.0) -> None:
        """Order again and again until a state is there."""
        end = time.monotonic() + seconds
        while True:
            for message in self._states.take(100):
                self.state = TYPES.read(STATE.type, message.content)
                if self.state == state:
                    return
            assert time.monotonic() < end, f"no {state.name}, but {self.state}"
            if order:
                message = self._empty()
                message.content = TYPES.write(ORDERS[0].type, None, 0)
                self._orders[order].write(message)
            time.sleep(0.05)


@contextmanager
def running(environment: dict[str, str], log: Path, *words: str) -> Iterator[Callable[[str], None]]:
    """A node; gives what waits until it has said something."""
    with log.open("wb") as out:
        command = [sys.executable, "-m", "skylimb", "ros2", *words]
        process = subprocess.Popen(command, env=environment, stdout=out, stderr=subprocess.STDOUT)

    def wait(said: str) -> None:
        end = time.monotonic() + 60.0
        while said not in (text := log.read_text(encoding="utf-8")):
            assert time.monotonic() < end, f"{said!r} is not in\n{text}"
            time.sleep(0.05)

    try:
        yield wait
    finally:
        process.kill()
        process.wait(60)


def require_time(said: str) -> None:
    """Skip where the machine was too busy for a flight in real time, as the node itself says."""
    if "fault: missed tick" in said or "too old" in said:
        pytest.skip("this machine is too busy: ticks were missed")


@pytest.mark.slow
def test_a_controller_that_was_killed_lands_the_robot(domain: dict[str, str], tmp_path: Path) -> None:
    controller = ("controller", "--bare", "--controller", "hybrid")
    with running(domain, tmp_path / "simulator.log", "simulator", "--experiment", "paper") as simulated:
        simulated("below /skylimb")
        user = User()
        with running(domain, tmp_path / "first.log", *controller) as said:
            said("below /skylimb")
            time.sleep(2.0)
            user.until(FlightState.ARM_ON, "start")
            try:
                user.until(FlightState.HOVER, "takeoff")
            except AssertionError:
                require_time((tmp_path / "first.log").read_text(encoding="utf-8"))
                raise
        with running(domain, tmp_path / "second.log", *controller) as said:
            said("the flight controller is armed, and nobody here armed it: landing")
            said("STOP -> ARM_OFF")  # states that users see may be of before, or too short to be seen
            user.until(FlightState.ARM_OFF)
    text = (tmp_path / "second.log").read_text(encoding="utf-8")
    assert re.search(r"LAND -> STOP\n.*STOP -> ARM_OFF", text, re.DOTALL)
    assert "Traceback" not in text
