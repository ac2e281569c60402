"""What is believed of a measurement before anything flies."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from skylimb.base.errors import ConfigError
from skylimb.control.estimation.records import Measurement
from skylimb.control.supervisor.limits import Limits
from skylimb.flight.realtime.watchdog import Watchdog
from skylimb.robots.model import Robot

Make = Callable[..., Measurement]
DT = 0.005

SPOILT: list[tuple[dict[str, Any], str]] = [
    ({"quaternion": np.zeros(3)}, "wrong size"),
    ({"joint_angles": np.zeros(2)}, "wrong size"),
    ({"joint_angles": "three"}, "no numbers"),
    ({"position": np.array([0.0, np.nan, 1.0])}, "not finite"),
    ({"velocity": np.array([np.inf, 0.0, 0.0])}, "not finite"),
    ({"quaternion": np.zeros(4)}, "no attitude"),
    ({"quaternion": np.array([2.0, 0.0, 0.0, 0.0])}, "no attitude"),
    ({"joint_angles": np.array([0.0, 9.0, 0.0])}, "angle out of range"),
    ({"joint_angles": np.array([0.0, np.nan, 0.0])}, "not finite"),
    ({"vectoring_angles": np.array([0.0, -9.0, 0.0, 0.0])}, "angle out of range"),
    ({"velocity": np.array([0.0, 0.0, -11.0])}, "too fast"),
    ({"angular_velocity": np.array([0.0, 30.0, 0.0])}, "too fast"),
    ({"position": np.array([3.0, 0.0, 1.0])}, "jump"),
    ({"quaternion": np.array([0.0, 1.0, 0.0, 0.0])}, "jump"),
]


@pytest.mark.parametrize(("changes", "fault"), SPOILT)
def test_what_is_not_believed_is_counted_and_not_used(
    robot: Robot, hovering: Make, changes: dict[str, Any], fault: str
) -> None:
    watchdog, good = Watchdog(robot), hovering()
    watchdog.judge(good, 0.0)
    for k in range(1, 30):
        watchdog.judge(hovering(**changes), k * DT)
    assert watchdog.counts == {fault: 29}
    assert watchdog.good is good


def test_a_negated_quaternion_and_a_slow_drift_are_no_jump(robot: Robot, hovering: Make) -> None:
    watchdog = Watchdog(robot)
    for k in range(100):
        turned = np.array([-1.0 if k % 2 else 1.0, 0.0, 0.0, 0.0])
        seen = hovering(quaternion=turned, position=np.array([0.01 * k, 0.0, 1.0]))
        watchdog.judge(seen, k * DT)
        assert watchdog.good is seen
    assert not watchdog.counts


def test_what_is_said_again_gets_no_younger(robot: Robot, hovering: Make) -> None:
    watchdog = Watchdog(robot)
    watchdog.judge(hovering(), 1.0)
    first = watchdog.good
    for taken in (1.0, 0.9, float("nan")):
        watchdog.judge(hovering(), taken)
    watchdog.judge(None, 2.0)
    assert watchdog.good is first


def test_each_fault_is_named_once(robot: Robot, hovering: Make, caplog: pytest.LogCaptureFixture) -> None:
    watchdog = Watchdog(robot)
    for k in range(5):
        watchdog.judge(hovering(quaternion=np.zeros(4)), k * DT)
    assert [record.message for record in caplog.records].count("watchdog: no attitude") == 1
    assert watchdog.counts["no attitude"] == 5


def test_limits_are_checked() -> None:
    with pytest.raises(ConfigError, match="overruns = 0"):
        Limits(overruns=0)
