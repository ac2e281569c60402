"""The lab's services that make servos limp: on the ground, and never in flight."""

from __future__ import annotations

import threading
import time
from typing import Any

import pytest

from skylimb.analysis.exchange import lab_topics as topics
from skylimb.analysis.exchange.messages import ServoTorques
from skylimb.apps.ros import asking
from skylimb.apps.ros.answers import ANSWER
from skylimb.apps.ros.asking import Calls, Switch
from skylimb.apps.ros.messages import Arrived
from skylimb.apps.ros.profile import profile_services
from wired import Wire


def switched(wire: Wire, topic: topics.Topic, on: bool, *orders: str) -> list[Any]:
    """What the controller says of it."""
    wire.pacer.wait(wire.k)
    now = wire.pacer.time()
    came = [Arrived(topic.name, Switch(7, on), "service", now)] if topic.name else []
    came += [Arrived(order, None, "/client", now) for order in orders]
    told = wire.pilot.tick(came, now)
    wire.k += 1
    return [one.value for one in told if one.topic in (ANSWER, topics.SERVO_TORQUE)]


def test_servos_go_limp_on_the_ground_and_hold_before_anything_flies() -> None:
    wire = Wire(("motor_info.yaml", "servo.yaml"))
    wire.fly(0.15)
    assert switched(wire, topics.JOINTS_TORQUE, False) == [
        ServoTorques(bytes([0, 2, 4]), bytes(3)),
        (7, True, "ARM_OFF"),
    ]
    limp = switched(wire, topics.GIMBALS_TORQUE, False)
    assert limp[0] == ServoTorques(bytes([1, 3, 5, 6]), bytes(4))
    nobody = topics.Topic("", "")
    again = switched(wire, nobody, True, "teleop_command/start")
    assert {one.numbers: one.on for one in again} == {
        bytes([0, 2, 4]): bytes([1] * 3),
        bytes([1, 3, 5, 6]): bytes([1] * 4),
    }
    assert switched(wire, topics.JOINTS_TORQUE, False) == [(7, False, "not in START")]


def test_a_call_is_answered_or_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    calls, found = Calls(), list[tuple[bool, str]]()
    caller = threading.Thread(target=lambda: found.append(calls.ask("joints/torque_enable", False)))
    caller.start()
    while not (came := calls.take()):
        time.sleep(0.001)
    assert came[0].value == Switch(1, False)
    calls.answer(1, True, "ARM_OFF")
    caller.join()
    assert found == [(True, "ARM_OFF")]
    monkeypatch.setattr(asking, "PATIENCE", 0.01)
    assert calls.ask("joints/torque_enable", True) == (False, "no answer within 0.01 s")
    calls.answer(2, True, "too late")


def test_whoever_stands_for_the_servo_bridge_offers_its_services() -> None:
    names = ["joints/torque_enable", "gimbals/torque_enable"]
    assert [one.name for one in profile_services("controller", True)] == names
    assert [one.name for one in profile_services("both")] == names
    assert profile_services("controller") == profile_services("simulator", True) == ()
