"""What is written is read again, and every topic of the table can be written."""

from __future__ import annotations

from pathlib import Path as Folder
from typing import Any

import numpy as np
import pytest

from skylimb.analysis.exchange import lab_topics as topics
from skylimb.analysis.exchange.codec import message_of, plain_of
from skylimb.analysis.exchange.lab_topics import Topic
from skylimb.analysis.exchange.message_types import Definitions
from skylimb.analysis.exchange.messages import (
    Desire,
    FourAxes,
    Gains,
    Imu,
    Joints,
    Motor,
    MotorInfo,
    Nav,
    Path,
    PMatrix,
    Pose,
    ServoStates,
    ServoTargets,
    UavInfo,
)

POSE = Pose(12.25, (1.0, 2.0, 3.0), (0.5, 0.5, -0.5, 0.5))
MOTOR = Motor(25.0, 33.0, (0.5, -5.25, 0.125, 0.0, 0.0))


@pytest.fixture(scope="module")
def definitions() -> Definitions:
    return Definitions([Folder(__file__).parent / "messages"])


def there_and_back(definitions: Definitions, topic: Topic, value: Any) -> Any:
    assert definitions.knows(topic.type)
    types = definitions.types
    raw = types.serialize_ros1(message_of(types, topic.type, value), topic.type)
    return types.deserialize_ros1(bytes(raw), topic.type)


@pytest.mark.parametrize(
    ("topic", "value"),
    [
        (topics.MOCAP, POSE),
        (topics.TARGET_PATH, Path((POSE, POSE))),
        (topics.IMU, Imu(12.25, (1.0, 2.0, 3.0), (4.0, 5.0, 6.0), (0.5, -0.5, 0.5, 0.5))),
        (topics.JOINT_STATES, Joints(12.25, ("joint1", "gimbal1"), (0.5, -0.25))),
        (topics.FOUR_AXES, FourAxes((0.0, 0.5, 1.0), (1.0, 2.0, 3.0, 4.0))),
        (topics.GAINS, Gains(((1, 2, 3, -4, 5, 6, 7), (0,) * 7))),
        (topics.P_MATRIX, PMatrix(((1, 2, 3), (-4, 5, 6)), (1, 2, 3, 4, 5, 6))),
        (topics.SERVO_STATES, ServoStates(12.25, ((0, 2047), (6, -326)))),
        (topics.SERVO_TARGETS, ServoTargets(bytes((0, 200)), (2047, -326))),
        (topics.MOTOR_INFO, MotorInfo(0.5, 0.75, 1.0, 7.0, 0, (MOTOR,))),
        (topics.UAV_INFO, UavInfo(4, 17)),
        (topics.DESIRE, Desire(0.5, 0.25, -0.5)),
        (topics.CONFIG, 2),
        (topics.STATE, 17),
        (topics.MISSION, "paper"),
        (topics.ORDERS[0], None),
    ],
)  # fmt: skip
def test_what_is_written_is_read_again(definitions: Definitions, topic: Topic, value: Any) -> None:
    assert plain_of(there_and_back(definitions, topic, value)) == value


def test_fields_that_are_not_given_are_zero_and_unknown_ones_are_refused(definitions: Definitions) -> None:
    message = there_and_back(definitions, topics.NAV, {"pos_xy_nav_mode": 1, "target_vel_x": 0.5})
    assert plain_of(message) == Nav(1, 0, 0, (0.0, 0.0, 0.0), (0.5, 0.0, 0.0))
    with pytest.raises(KeyError, match="has no field speed"):
        message_of(definitions.types, topics.NAV.type, {"speed": 1.0})


def test_what_nobody_here_reads_has_the_fields_that_are_given(definitions: Definitions) -> None:
    odometry = there_and_back(
        definitions, topics.COG, {"header.stamp": 2.5, "twist.twist.linear": (1.0, 2.0, 3.0)}
    )
    assert (odometry.header.stamp.sec, odometry.header.stamp.nanosec) == (2, 500_000_000)
    assert plain_of(odometry, "twist.twist.linear") == (1.0, 2.0, 3.0)
    assert odometry.pose.covariance.shape == (36,)
    frames = {"transforms": [{"child_frame_id": "root", "transform.rotation": (1.0, 0.0, 0.0, 0.0)}]}
    (frame,) = there_and_back(definitions, topics.TF, frames).transforms
    assert (frame.child_frame_id, frame.transform.rotation.w) == ("root", 1.0)
    row = there_and_back(definitions, topics.ROW, {"data": np.array([0.5, np.nan])})
    np.testing.assert_array_equal(row.data, [0.5, np.nan])
    status = {"level": 2, "name": "skylimb", "values": [{"key": "a", "value": "b"}]}
    (shown,) = there_and_back(definitions, topics.DIAGNOSTICS, {"status": [status]}).status
    assert (shown.level, shown.values[0].key) == (2, "a")


def test_servo_targets_have_a_number_each(definitions: Definitions) -> None:
    message = message_of(definitions.types, topics.SERVO_TARGETS.type, {"index": b"\x01", "angles": [1, 2]})
    with pytest.raises(ValueError, match="2 targets for 1 servos"):
        plain_of(message)
