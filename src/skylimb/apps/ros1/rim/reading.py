"""From ROS's messages to plain ones: fields by name, x y z w to w x y z, stamps in seconds."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from skylimb.apps.ros1 import topics
from skylimb.apps.ros1.messages import (
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
    ServoAngles,
    Turn,
    UavInfo,
    Vector,
)


def plain(topic: str, message: Any) -> Any:
    """The plain message of a topic; None for one without content.

    Raises:
        AttributeError: for a message without the fields that are read.
        ValueError: for values of the wrong size.
    """
    read = _READ.get(topic)
    return None if read is None else read(message)


def _seconds(stamp: Any) -> float:
    return float(stamp.to_sec())


def _xyz(value: Any) -> Vector:
    return float(value.x), float(value.y), float(value.z)


def _wxyz(value: Any) -> Turn:
    return float(value.w), float(value.x), float(value.y), float(value.z)


def _pose(message: Any) -> Pose:
    pose = message.pose
    return Pose(_seconds(message.header.stamp), _xyz(pose.position), _wxyz(pose.orientation))


def _path(message: Any) -> Path:
    return Path(tuple(_pose(pose) for pose in message.poses))


def _imu(message: Any) -> Imu:
    x, y, z, w = (float(part) for part in message.quaternion)
    gyro, acceleration = _triple(message.gyro), _triple(message.acc)
    return Imu(_seconds(message.stamp), (w, x, y, z), gyro, acceleration)


def _triple(values: Any) -> Vector:
    x, y, z = (float(value) for value in values)
    return x, y, z


def _joints(message: Any) -> Joints:
    angles = tuple(float(angle) for angle in message.position)
    return Joints(_seconds(message.header.stamp), tuple(message.name), angles)


def _nav(message: Any) -> Nav:
    return Nav(
        int(message.pos_xy_nav_mode),
        int(message.pos_z_nav_mode),
        int(message.yaw_nav_mode),
        (float(message.target_pos_x), float(message.target_pos_y), float(message.target_pos_z)),
        (float(message.target_vel_x), float(message.target_vel_y), float(message.target_vel_z)),
        float(message.target_yaw),
        float(message.target_omega_z),
        int(message.control_frame) == 1,
    )


def _four_axes(message: Any) -> FourAxes:
    return FourAxes(_triple(message.angles), tuple(float(thrust) for thrust in message.base_thrust))


GAINS = ("roll_p", "roll_i", "roll_d", "pitch_p", "pitch_i", "pitch_d", "yaw_d")
"""Fields of the gains of one motor, in their order."""


def _gains(message: Any) -> Gains:
    return Gains(tuple(tuple(int(getattr(motor, name)) for name in GAINS) for motor in message.motors))


def _p_matrix(message: Any) -> PMatrix:
    rows = tuple((int(row.r), int(row.p), int(row.y)) for row in message.pseudo_inverse)
    return PMatrix(rows, tuple(int(value) for value in message.inertia))


def _desire(message: Any) -> Desire:
    return Desire(float(message.roll), float(message.pitch), float(message.yaw))


def _servo_states(message: Any) -> ServoAngles:
    counts = {int(servo.index): int(servo.angle) for servo in message.servos}
    return ServoAngles(_seconds(message.stamp), counts)


def _servo_targets(message: Any) -> ServoAngles:
    # Numbers travel as bytes; a target without number, or a number without target, is neither.
    pairs = zip(bytes(message.index), message.angles, strict=True)
    return ServoAngles(0.0, {int(number): int(count) for number, count in pairs})


def _motor_info(message: Any) -> MotorInfo:
    motors = []
    for one in message.motor_info:
        a, b, c, d, e = (float(value) for value in one.polynominal)
        motors.append(Motor(float(one.voltage), float(one.max_thrust), (a, b, c, d, e)))
    return MotorInfo(
        float(message.min_pwm),
        float(message.max_pwm),
        float(message.min_thrust),
        float(message.force_landing_thrust),
        int(message.pwm_conversion_mode),
        tuple(motors),
    )


def _uav_info(message: Any) -> UavInfo:
    return UavInfo(int(message.motor_num), int(message.uav_model))


def _data(message: Any) -> Any:
    return message.data


def _command(message: Any) -> int:
    return int(message.cmd)


_READ: dict[str, Callable[[Any], Any]] = {
    topics.MOCAP.name: _pose,
    topics.TARGET_POSE.name: _pose,
    topics.TARGET_PATH.name: _path,
    topics.IMU.name: _imu,
    topics.JOINT_STATES.name: _joints,
    topics.JOINTS_CTRL.name: _joints,
    topics.GIMBALS_CTRL.name: _joints,
    topics.SERVO_STATES.name: _servo_states,
    topics.SERVO_TARGETS.name: _servo_targets,
    topics.MOTOR_INFO.name: _motor_info,
    topics.UAV_INFO.name: _uav_info,
    topics.NAV.name: _nav,
    topics.FOUR_AXES.name: _four_axes,
    topics.CONFIG.name: _command,
    topics.GAINS.name: _gains,
    topics.P_MATRIX.name: _p_matrix,
    topics.DESIRE.name: _desire,
    topics.ACK.name: _data,
    topics.BATTERY.name: _data,
    topics.MISSION.name: _data,
}
