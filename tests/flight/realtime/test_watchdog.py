"""What is believed of a measurement."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from skylimb.base.errors import ConfigError
from skylimb.control.estimation.records import Measurement
from skylimb.flight.realtime.watchdog import Limits, State, Watchdog
from skylimb.robots.model import Robot

Make = Callable[..., Measurement]
DT = 0.005


def test_a_fresh_measurement_flies_an_old_one_holds_then_retreats(robot: Robot, hovering: Make) -> None:
    watchdog = Watchdog(robot)
    assert watchdog.judge(hovering(), 0.0, 0.0) == State.FLY
    states = {age: watchdog.judge(None, 0.0, age) for age in (0.05, 0.099, 0.11, 0.3, 0.499, 0.51, 5.0)}
    assert [age for age, state in states.items() if state == State.FLY] == [0.05, 0.099]
    assert [age for age, state in states.items() if state == State.HOLD] == [0.11, 0.3, 0.499]
    assert [age for age, state in states.items() if state == State.RETREAT] == [0.51, 5.0]
    assert watchdog.judge(hovering(), 5.1, 5.1) == State.FLY


def test_before_the_first_measurement_it_holds(robot: Robot) -> None:
    watchdog = Watchdog(robot)
    assert watchdog.judge(None, 0.0, 100.0) == State.HOLD
    assert watchdog.judge(None, 0.0, 100.3) == State.HOLD
    assert watchdog.judge(None, 0.0, 101.0) == State.RETREAT
    assert watchdog.good is None


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"position": np.array([0.0, np.nan, 1.0])}, "not finite"),
        ({"velocity": np.array([np.inf, 0.0, 0.0])}, "not finite"),
        ({"quaternion": np.zeros(4)}, "no attitude"),
        ({"quaternion": np.array([2.0, 0.0, 0.0, 0.0])}, "no attitude"),
        ({"quaternion": np.zeros(3)}, "wrong size"),
        ({"joint_angles": np.zeros(2)}, "wrong size"),
        ({"joint_angles": "three"}, "no numbers"),
        ({"joint_angles": np.array([0.0, 9.0, 0.0])}, "angle out of range"),
        ({"vectoring_angles": np.array([0.0, -9.0, 0.0, 0.0])}, "angle out of range"),
        ({"velocity": np.array([0.0, 0.0, -11.0])}, "too fast"),
        ({"angular_velocity": np.array([0.0, 30.0, 0.0])}, "too fast"),
        ({"position": np.array([3.0, 0.0, 1.0])}, "jump"),
        ({"quaternion": np.array([0.0, 1.0, 0.0, 0.0])}, "jump"),
    ],
)
def test_what_is_not_believed_is_counted_and_not_used(
    robot: Robot, hovering: Make, changes: dict[str, Any], fault: str
) -> None:
    watchdog, good = Watchdog(robot), hovering()
    watchdog.judge(good, 0.0, 0.0)
    for k in range(1, 30):
        state = watchdog.judge(hovering(**changes), k * DT, k * DT)
        assert state == (State.FLY if k <= 20 else State.HOLD)
    assert watchdog.counts[fault] >= 2
    assert watchdog.good is good


def test_a_negated_quaternion_and_a_slow_drift_are_no_jump(robot: Robot, hovering: Make) -> None:
    watchdog = Watchdog(robot)
    for k in range(100):
        turned = np.array([-1.0 if k % 2 else 1.0, 0.0, 0.0, 0.0])
        moved = np.array([0.01 * k, 0.0, 1.0])
        assert watchdog.judge(hovering(quaternion=turned, position=moved), k * DT, k * DT) == State.FLY
    assert not watchdog.counts


def test_what_is_said_again_gets_no_younger(robot: Robot, hovering: Make) -> None:
    watchdog = Watchdog(robot)
    watchdog.judge(hovering(), 1.0, 1.0)
    first = watchdog.good
    assert watchdog.judge(hovering(), 1.0, 1.05) == State.FLY
    assert watchdog.judge(hovering(), 1.0, 1.2) == State.HOLD
    assert watchdog.judge(hovering(), 0.9, 1.21) == State.HOLD
    assert watchdog.good is first


def test_each_fault_is_named_once(robot: Robot, hovering: Make, caplog: pytest.LogCaptureFixture) -> None:
    watchdog = Watchdog(robot)
    for k in range(5):
        watchdog.judge(hovering(quaternion=np.zeros(4)), k * DT, k * DT)
    assert [record.message for record in caplog.records].count("watchdog: no attitude") == 1
    assert watchdog.counts["no attitude"] == 5


def test_limits_are_checked(robot: Robot, hovering: Make) -> None:
    with pytest.raises(ConfigError, match="overruns = 0"):
        Limits(overruns=0)
    quick = Watchdog(robot, Limits(hold_after=0.01, retreat_after=0.02))
    quick.judge(hovering(), 0.0, 0.0)
    assert quick.judge(None, 0.0, 0.03) == State.RETREAT
