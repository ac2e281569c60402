"""Clocks of the sensors are set in flight: the robot hovers on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from skylimb.analysis.exchange import lab_topics as topics
from skylimb.apps.ros.messages import Outgoing
from skylimb.apps.ros.states import FlightState
from wired import in_hover

STEPS = (
    (topics.MOCAP, -0.3),
    (topics.MOCAP, 0.3),
    (topics.MOCAP, -2.0),
    (topics.JOINT_STATES, -2.0),
    (topics.IMU, 0.3),
)


def test_a_clock_that_is_set_moves_no_robot() -> None:
    wire = in_hover()
    wire.fly(2.0)
    wire.where.clear()
    ahead = {topic.name: 0.0 for topic, _ in STEPS}

    def spoil(one: Outgoing) -> Outgoing:
        step = ahead.get(one.topic.name)
        return one if step is None else Outgoing(one.topic, replace(one.value, stamp=one.value.stamp + step))

    wire.spoil = spoil
    for topic, step in STEPS:
        ahead[topic.name] += step
        wire.fly(0.7)
        assert wire.pilot.faults[f"{topic.name}: clock of the stamps was set"] > 0
    assert wire.pilot.pilot.flying.state == FlightState.HOVER
    # Ticks that were coasted until the clock was read anew.
    assert wire.pilot.faults["pose too old"] <= 5 * sum(topic is topics.MOCAP for topic, _ in STEPS)
    assert sum(count for name, count in wire.pilot.faults.items() if name.endswith("was set")) == len(STEPS)
    away = np.array(wire.where) - wire.where[0]
    assert np.linalg.norm(away, axis=1).max() < 0.03


@pytest.mark.parametrize("step", [-2.0, 0.3])
def test_a_computer_whose_clock_is_set_moves_no_robot(step: float) -> None:
    """Whoever stamps by the same clock steps at once: capture, IMU and joints."""
    wire = in_hover()
    wire.fly(2.0)
    wire.where.clear()
    sensors = {topic.name for topic, _ in STEPS}

    def spoil(one: Outgoing) -> Outgoing:
        ahead = step if one.topic.name in sensors else 0.0
        return Outgoing(one.topic, replace(one.value, stamp=one.value.stamp + ahead)) if ahead else one

    wire.spoil = spoil
    wire.fly(1.5)
    assert sum(count for name, count in wire.pilot.faults.items() if name.endswith("was set")) == len(sensors)
    assert wire.pilot.pilot.flying.state == FlightState.HOVER
    away = np.array(wire.where) - wire.where[0]
    assert np.linalg.norm(away, axis=1).max() < 0.03
