"""The clock of the motion capture is set in flight; every message goes over real DDS, time is the test's."""

from __future__ import annotations

import contextlib
import functools
import time
from collections import deque
from dataclasses import replace

import numpy as np
import pytest

from skylimb.analysis.exchange import lab_topics as topics
from skylimb.apps.ros.messages import Arrived, Outgoing
from skylimb.apps.ros.states import FlightState
from skylimb.apps.ros2.connection import Dds
from skylimb.apps.ros2.dialect import ROS2_DIALECT
from wired import Wire

STEPS = (-0.3, 0.3, -2.0)
"""By which it is set, s."""


class OverDds(Wire):
    """Controller and simulator, each behind its own participant; a tick waits for what was said."""

    def __init__(self) -> None:
        super().__init__(files=(), dialect=ROS2_DIALECT)
        self._sides = {
            sender: Dds(profile, [], "skylimb", False, False)
            for sender, profile in (("/spinal", "simulator"), ("/skylimb", "controller"))
        }
        robot, ours = (ROS2_DIALECT.topics(profile, False) for profile in ("simulator", "controller"))
        self._carried = {
            "/spinal": {topic.name for topic in robot.published if topic in ours.subscribed},
            "/skylimb": {topic.name for topic in ours.published if topic in robot.subscribed},
        }
        self.lost, end = 0, time.monotonic() + 30.0
        for sender, names in self._carried.items():
            publishers = self._sides[sender]._outbox._publishers
            while not all(publishers[name][1].get_num_connections() for name in names):
                assert time.monotonic() < end, "the two do not find each other"
                time.sleep(0.05)

    def heard(self, messages: deque[Outgoing], sender: str, now: float) -> list[Arrived]:
        other = next(side for name, side in self._sides.items() if name != sender)
        sent = [(topic.name, value) for topic, value in messages if topic.name in self._carried[sender]]
        messages.clear()
        self._sides[sender].publish(sent)
        found, end = list[Arrived](), time.monotonic() + 0.5
        while len(found) < len(sent) and time.monotonic() < end:
            found += [one._replace(at=now) for one in other.take()]
        self.lost += len(sent) - len(found)
        return found

    def close(self) -> None:
        """Both leave, also when a failed test's traceback holds this: a process has one domain at a time."""
        self._sides.clear()


@pytest.mark.slow
def test_a_clock_that_is_set_moves_no_robot(domain: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> None:
    import cyclonedds.domain

    # A process configures a domain once; here two nodes live in one.
    monkeypatch.setattr(cyclonedds.domain, "Domain", functools.cache(cyclonedds.domain.Domain))
    with contextlib.closing(OverDds()) as wire:
        _set_clocks(wire)


def _set_clocks(wire: OverDds) -> None:
    ahead = 0.0
    wire.hover()
    wire.fly(2.0)
    wire.where.clear()

    def spoil(one: Outgoing) -> Outgoing:
        if one.topic.name != topics.MOCAP.name:
            return one
        return Outgoing(one.topic, replace(one.value, stamp=one.value.stamp + ahead))

    wire.spoil = spoil
    for count, step in enumerate(STEPS, 1):
        ahead += step
        wire.fly(0.7)
        assert wire.pilot.faults["mocap/pose: clock of the stamps was set"] == count
    assert wire.pilot.pilot.flying.state == FlightState.HOVER
    # A fifth pose that agrees is believed, after 50 ms; those behind the first 20 coast.
    assert wire.pilot.faults["pose too old"] <= 6 * len(STEPS)
    assert wire.lost < 5  # of the best effort
    away = np.array(wire.where) - wire.where[0]
    assert np.linalg.norm(away, axis=1).max() < 0.03
