"""From plain messages to ROS's: fields by name, w x y z to x y z w, seconds to stamps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from skylimb.apps.ros1 import topics
from skylimb.apps.ros1.messages import (
    WORLD,
    Axis,
    Desire,
    Diagnosis,
    FourAxes,
    Gains,
    Imu,
    Joints,
    MotorInfo,
    Odometry,
    PMatrix,
    Pose,
    PoseControl,
    ServoAngles,
    Transforms,
    Turn,
    UavInfo,
    Vector,
    Wrench,
)
from skylimb.apps.ros1.rim.reading import GAINS

Find = Callable[[str], Any]
"""The class of a type, by name."""


def stamp_of(seconds: float) -> Any:
    """A stamp; times before 0 are 0."""
    import genpy

    return genpy.Time.from_sec(max(0.0, seconds))


def message_of(topic: topics.Topic, value: Any, find: Find) -> Any:
    """The message that carries a plain value on a topic."""
    message = find(topic.type)()
    _WRITE[type(value)](message, value, find) if type(value) in _WRITE else _write_data(
        topic, message, value, find
    )
    return message


def _write_data(topic: topics.Topic, message: Any, value: Any, find: Find) -> None:
    if topic == topics.CONFIG:
        message.cmd = int(value)
    elif isinstance(value, np.ndarray):
        message.data = value.tolist()
    elif isinstance(value, tuple):
        name, content = value
        message.data = content
        dimension = find("std_msgs/MultiArrayDimension")()
        dimension.label, dimension.size, dimension.stride = name, len(content), 1
        message.layout.dim = [dimension]
    else:
        message.data = value


def _set_header(message: Any, stamp: float, frame: str = WORLD) -> None:
    message.header.stamp, message.header.frame_id = stamp_of(stamp), frame


def _set_xyz(place: Any, values: Vector) -> None:
    place.x, place.y, place.z = values


def _set_turn(place: Any, values: Turn) -> None:
    place.w, place.x, place.y, place.z = values


def _write_pose(message: Any, value: Pose, find: Find) -> None:
    _set_header(message, value.stamp)
    _set_xyz(message.pose.position, value.position)
    _set_turn(message.pose.orientation, value.quaternion)


def _write_imu(message: Any, value: Imu, find: Find) -> None:
    message.stamp = stamp_of(value.stamp)
    w, x, y, z = value.quaternion
    message.quaternion = [x, y, z, w]
    message.gyro, message.acc = list(value.gyro), list(value.acceleration)


def _write_joints(message: Any, value: Joints, find: Find) -> None:
    _set_header(message, value.stamp, "")
    message.name, message.position = list(value.names), list(value.angles)


def _write_four_axes(message: Any, value: FourAxes, find: Find) -> None:
    message.angles, message.base_thrust = list(value.angles), list(value.base_thrust)


def _write_gains(message: Any, value: Gains, find: Find) -> None:
    for gains in value.motors:
        motor = find("spinal/RollPitchYawTerm")()
        for name, gain in zip(GAINS, gains, strict=True):
            setattr(motor, name, gain)
        message.motors.append(motor)


def _write_p_matrix(message: Any, value: PMatrix, find: Find) -> None:
    for row in value.rows:
        unit = find("spinal/PMatrixPseudoInverseUnit")()
        unit.r, unit.p, unit.y = row
        message.pseudo_inverse.append(unit)
    message.inertia = list(value.inertia)


def _write_desire(message: Any, value: Desire, find: Find) -> None:
    message.roll, message.pitch, message.yaw = value.roll, value.pitch, value.yaw


def _write_servos(message: Any, value: ServoAngles, find: Find) -> None:
    """States, or targets, which have no stamp."""
    if not hasattr(message, "servos"):
        message.index, message.angles = bytes(value.counts), list(value.counts.values())
        return
    message.stamp = stamp_of(value.stamp)
    for number, count in value.counts.items():
        servo = find("spinal/ServoState")()
        servo.index, servo.angle = number, count
        message.servos.append(servo)


def _write_motor_info(message: Any, value: MotorInfo, find: Find) -> None:
    message.min_pwm, message.max_pwm, message.min_thrust = value.min_pwm, value.max_pwm, value.min_thrust
    message.force_landing_thrust = value.force_landing_thrust
    message.pwm_conversion_mode = value.conversion
    for motor in value.motors:
        one = find("spinal/MotorInfo")()
        one.voltage, one.max_thrust = motor.voltage, motor.max_thrust
        one.polynominal = list(motor.polynomial)
        message.motor_info.append(one)


def _write_uav_info(message: Any, value: UavInfo, find: Find) -> None:
    message.motor_num, message.uav_model = value.motors, value.model


def _write_transforms(message: Any, value: Transforms, find: Find) -> None:
    for frame in value.frames:
        one = find("geometry_msgs/TransformStamped")()
        _set_header(one, frame.stamp, frame.parent)
        one.child_frame_id = frame.child
        _set_xyz(one.transform.translation, frame.position)
        _set_turn(one.transform.rotation, frame.quaternion)
        message.transforms.append(one)


def _write_odometry(message: Any, value: Odometry, find: Find) -> None:
    _set_header(message, value.stamp)
    message.child_frame_id = value.frame
    _set_xyz(message.pose.pose.position, value.position)
    _set_turn(message.pose.pose.orientation, value.quaternion)
    _set_xyz(message.twist.twist.linear, value.velocity)
    _set_xyz(message.twist.twist.angular, value.angular_velocity)


def _write_wrench(message: Any, value: Wrench, find: Find) -> None:
    _set_header(message, value.stamp)
    _set_xyz(message.wrench.force, value.force)
    _set_xyz(message.wrench.torque, value.torque)


def _write_control(message: Any, value: PoseControl, find: Find) -> None:
    _set_header(message, value.stamp)
    for name, axis in zip(("x", "y", "z", "roll", "pitch", "yaw"), value.axes, strict=True):
        _write_axis(getattr(message, name), axis)


def _write_axis(place: Any, axis: Axis) -> None:
    place.target_p, place.err_p = axis.target, axis.error
    place.target_d, place.err_d = axis.target_rate, axis.rate_error


def _write_diagnosis(message: Any, value: Diagnosis, find: Find) -> None:
    import rospy

    message.header.stamp = stamp_of(rospy.get_time())
    status = find("diagnostic_msgs/DiagnosticStatus")()
    status.level, status.name, status.message = value.level, "skylimb", value.words
    for key, word in value.values.items():
        entry = find("diagnostic_msgs/KeyValue")()
        entry.key, entry.value = key, word
        status.values.append(entry)
    message.status = [status]


_WRITE: dict[type, Callable[[Any, Any, Find], None]] = {
    Pose: _write_pose,
    Imu: _write_imu,
    Joints: _write_joints,
    FourAxes: _write_four_axes,
    Gains: _write_gains,
    PMatrix: _write_p_matrix,
    Desire: _write_desire,
    ServoAngles: _write_servos,
    MotorInfo: _write_motor_info,
    UavInfo: _write_uav_info,
    Transforms: _write_transforms,
    Odometry: _write_odometry,
    Wrench: _write_wrench,
    PoseControl: _write_control,
    Diagnosis: _write_diagnosis,
}
