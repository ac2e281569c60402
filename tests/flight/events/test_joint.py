"""Servos that fail: limp ones hold nothing, stuck ones stand still, others run away at their own speed."""

from typing import Any

import numpy as np

from activations import watched
from short_flights import HOLD
from skylimb.flight.events import JointFault
from skylimb.flight.takeoff import take_off

SERVO = {"kind": "joint", "joint": "gimbal_joint2"}


def flown(seconds: float = 1.0, **fault: Any) -> tuple[np.ndarray, np.ndarray]:
    """Angle and set point of joint 2 at each tick of the first seconds."""
    event = {"kind": "joint", "joint": "joint2", "time": 0.3, **fault}
    flight, activations = watched(seconds, {**HOLD, "events": [event]})
    return flight.signal("configuration")[:, 10], activations[:, 5]


def test_one_that_runs_away_does_so_at_its_speed_and_comes_back() -> None:
    _, set_points = flown(speed=0.4, duration=0.5)
    rates = np.diff(set_points) / 0.005
    np.testing.assert_allclose(rates[60:160], 0.4, atol=1e-9)
    assert rates[165:].min() < -0.4


def test_a_stuck_one_keeps_its_set_point() -> None:
    _, whole = flown(3.0, strength=1.0)
    _, set_points = flown(3.0, speed=0.0)
    assert np.ptp(whole) > 0.01
    assert np.ptp(set_points) == 0.0


def test_a_limp_one_lets_the_arm_hang() -> None:
    angles, set_points = flown(strength=0.0)
    assert abs(angles[:60] - set_points[:60]).max() < 0.2
    assert abs(angles - set_points).max() > 0.5


def test_two_faults_of_one_joint_go_together() -> None:
    faults = [
        {**SERVO, "time": 0.5, "strength": 0.5},
        {**SERVO, "time": 1.0, "strength": 0.5, "speed": 1.0, "duration": 0.5},
    ]
    (takeoff,) = take_off("paper", ("hybrid",), set={**HOLD, "events": faults})
    rows = takeoff.timeline(takeoff.times).model
    assert rows is not None
    model = takeoff.plant.model
    (index,) = {place.row for place in rows.places}
    assert model.actuator(index).name == "gimbal_joint2"
    wanted = (50, 1.0, [-20.0, 20.0]), (150, 0.5, [-20.0, 20.0]), (250, 0.25, [1.0, 1.0])
    for tick, strength, limits in wanted:
        np.testing.assert_allclose(rows.values[tick, 0], strength * model.actuator_gainprm[index, 0])
        np.testing.assert_allclose(rows.values[tick, 1:4], strength * model.actuator_biasprm[index, :3])
        np.testing.assert_array_equal(rows.values[tick, 4:6], limits)


def test_what_it_is_called() -> None:
    assert JointFault(1.0, "joint2", strength=0.0).words == "joint2 limp"
    assert JointFault(1.0, "joint2", speed=0.0).words == "joint2 stuck"
    words = "gimbal_joint1 at 0.5 of its strength and running away at 2.0 rad/s"
    assert JointFault(1.0, "gimbal_joint1", strength=0.5, speed=2.0).words == words
