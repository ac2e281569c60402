"""Between plain values and ROS messages of a type store, by one table of fields.

Stamps are seconds, vectors x y z, quaternions w x y z, lists tuples, and bytes bytes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import is_dataclass
from typing import Any, NamedTuple

import numpy as np

from skylimb.analysis.exchange.messages import (
    WORLD,
    Desire,
    FourAxes,
    Gains,
    Imu,
    Joints,
    Joy,
    Motor,
    MotorInfo,
    Nav,
    NavMode,
    Path,
    PMatrix,
    Pose,
    Pwms,
    ServoStates,
    ServoTargets,
    ServoTorques,
    TorqueInverse,
    UavInfo,
)

_TIME = "builtin_interfaces/msg/Time"
_ZERO = {"string": "", "bool": False, "float32": 0.0, "float64": 0.0}


class Form(NamedTuple):
    """How a message is a plain value.

    Attributes:
        make: from the values of the fields, in their order.
        fields: by their path in the message.
        always: fields that are written besides, and not read.
    """

    make: Callable[..., Any]
    fields: tuple[str, ...]
    always: Mapping[str, Any] = {}


def _row(*values: Any) -> tuple[Any, ...]:
    return values


def _itself(value: Any) -> Any:
    return value


def _steered(frame: str, velocity: Any, rates: Any) -> Nav:
    """Velocities in W, or in the robot's own axes."""
    mode, still = NavMode.VELOCITY, (0.0, 0.0, 0.0)
    return Nav(mode, mode, mode, still, velocity, yaw_rate=rates[2], frame=int(frame != WORLD))


FORMS = {
    "geometry_msgs/msg/Point": Form(_row, ("x", "y", "z")),
    "geometry_msgs/msg/Vector3": Form(_row, ("x", "y", "z")),
    "geometry_msgs/msg/Quaternion": Form(_row, ("w", "x", "y", "z")),
    "geometry_msgs/msg/Pose": Form(lambda position, turn: (*position, *turn), ("position", "orientation")),
    "geometry_msgs/msg/PoseStamped": Form(
        Pose, ("header.stamp", "pose.position", "pose.orientation", "header.frame_id")
    ),
    "nav_msgs/msg/Path": Form(Path, ("poses", "header.frame_id")),
    "sensor_msgs/msg/JointState": Form(Joints, ("header.stamp", "name", "position")),
    "sensor_msgs/msg/Joy": Form(Joy, ("header.stamp", "axes", "buttons")),
    "spinal/msg/Imu": Form(Imu, ("stamp", "gyro", "acc", "quaternion", "mag")),
    "spinal/msg/FourAxisCommand": Form(FourAxes, ("angles", "base_thrust")),
    "spinal/msg/RollPitchYawTerm": Form(
        _row, ("roll_p", "roll_i", "roll_d", "pitch_p", "pitch_i", "pitch_d", "yaw_d")
    ),
    "spinal/msg/RollPitchYawTerms": Form(Gains, ("motors",)),
    "spinal/msg/PMatrixPseudoInverseUnit": Form(_row, ("r", "p", "y")),
    "spinal/msg/PMatrixPseudoInverseWithInertia": Form(PMatrix, ("pseudo_inverse", "inertia")),
    "spinal/msg/Vector3Int16": Form(_row, ("x", "y", "z")),
    "spinal/msg/TorqueAllocationMatrixInv": Form(TorqueInverse, ("rows",)),
    "spinal/msg/DesireCoord": Form(Desire, ("roll", "pitch", "yaw")),
    "spinal/msg/FlightConfigCmd": Form(_itself, ("cmd",)),
    "spinal/msg/ServoState": Form(_row, ("index", "angle")),
    "spinal/msg/ServoStates": Form(ServoStates, ("stamp", "servos")),
    "spinal/msg/ServoControlCmd": Form(ServoTargets, ("index", "angles")),
    "spinal/msg/ServoTorqueCmd": Form(ServoTorques, ("index", "torque_enable")),
    "spinal/msg/MotorInfo": Form(Motor, ("voltage", "max_thrust", "polynominal")),
    "spinal/msg/PwmInfo": Form(
        MotorInfo,
        ("min_pwm", "max_pwm", "min_thrust", "force_landing_thrust", "pwm_conversion_mode", "motor_info"),
    ),
    "spinal/msg/Pwms": Form(Pwms, ("stamp", "motor_value")),
    "spinal/msg/UavInfo": Form(UavInfo, ("motor_num", "uav_model")),
    "aerial_robot_msgs/msg/FlightNav": Form(
        lambda xy, z, yaw, x, y, height, vx, vy, vz, *more: Nav(
            xy, z, yaw, (x, y, height), (vx, vy, vz), *more
        ),
        (
            *("pos_xy_nav_mode", "pos_z_nav_mode", "yaw_nav_mode"),
            *("target_pos_x", "target_pos_y", "target_pos_z"),
            *("target_vel_x", "target_vel_y", "target_vel_z"),
            *("target_yaw", "target_omega_z", "control_frame"),
        ),
    ),
    "sensor_msgs/msg/Imu": Form(
        lambda stamp, gyro, force, turn: Imu(stamp, gyro, force, (*turn[1:], turn[0])),
        ("header.stamp", "angular_velocity", "linear_acceleration", "orientation"),
    ),
    "sensor_msgs/msg/BatteryState": Form(_itself, ("voltage",), {"present": True}),
    "geometry_msgs/msg/TwistStamped": Form(_steered, ("header.frame_id", "twist.linear", "twist.angular")),
    "skylimb_msgs/msg/RotorThrusts": Form(FourAxes, ("attitude_terms", "thrusts")),
    "skylimb_msgs/msg/MotorDuties": Form(Pwms, ("stamp", "duties")),
    "skylimb_msgs/msg/ControlledAxes": Form(Desire, ("roll", "pitch", "yaw")),
    "skylimb_msgs/msg/Arming": Form(_itself, ("command",)),
    "std_msgs/msg/Empty": Form(lambda: None, ()),
    "std_msgs/msg/UInt8": Form(_itself, ("data",)),
    "std_msgs/msg/Float32": Form(_itself, ("data",)),
    "std_msgs/msg/String": Form(_itself, ("data",)),
}
"""By type; the fields of a plain value's class in their order."""


def plain_of(value: Any, path: str = "") -> Any:
    """The plain value of a message, or of the part of it that a path leads to.

    Raises:
        AttributeError: for a message without the fields that are read.
        ValueError: for values that do not fit together.
    """
    for name in filter(None, path.split(".")):
        value = getattr(value, name)
    kind = getattr(value, "__msgtype__", "")
    if kind == _TIME:
        return value.sec + value.nanosec * 1e-9
    if kind in FORMS:
        return FORMS[kind].make(*(plain_of(value, field) for field in FORMS[kind].fields))
    if isinstance(value, np.ndarray):
        return value.tobytes() if value.dtype == np.uint8 else tuple(value.tolist())
    return tuple(map(plain_of, value)) if isinstance(value, list) else value


def message_of(types: Any, kind: str, value: Any, seq: int = 0) -> Any:
    """The message of a type that carries a plain value.

    Args:
        types: the type store.
        kind: "geometry_msgs/msg/PoseStamped".
        value: of the class that `FORMS` names, or fields by their path; fields that are not given are zero.
        seq: number of the message, for its header.

    Raises:
        KeyError: for a field that the type does not have.
    """
    message = _message(types, kind, value)
    if hasattr(getattr(message, "header", None), "seq"):  # ROS 2 numbers none
        message.header.seq = seq
    return message


def _message(types: Any, kind: str, value: Any) -> Any:
    if kind == _TIME:
        sec, nanosec = divmod(round(max(0.0, value or 0.0) * 1e9), 10**9)
        return types.types[kind](sec=sec, nanosec=nanosec)
    given = value if isinstance(value, Mapping) else _fields(kind, value)
    parts: dict[str, Any] = {}
    for path, part in given.items():
        head, _, rest = path.partition(".")
        parts.setdefault(head, {}).update({rest: part}) if rest else parts.update({head: part})
    made = {name: _value(types, form, parts.pop(name, None)) for name, form in types.fielddefs[kind][1]}
    if parts:
        raise KeyError(f"{kind} has no field {', '.join(parts)}")
    return types.types[kind](**made)


def _fields(kind: str, value: Any) -> Mapping[str, Any]:
    """Fields of a plain value by their path; none of a value that is not given."""
    if value is None:
        return {}
    form = FORMS[kind]
    if is_dataclass(value):
        value = vars(value).values()
    elif not isinstance(value, tuple):
        value = (value,)
    return {**form.always, **dict(zip(form.fields, value, strict=True))}


def _value(types: Any, form: Any, value: Any) -> Any:
    """A field of a form of rosbags; zero, or empty, where no value is given."""
    from rosbags.interfaces import Nodetype

    node, detail = form
    if node == Nodetype.NAME:
        return _message(types, detail, value)
    if node == Nodetype.BASE:
        return _ZERO.get(detail[0], 0) if value is None else value
    (element, kind), length = detail
    if element == Nodetype.NAME:
        return [_message(types, kind, one) for one in value or ()]
    if kind[0] == "string":
        return list(value or ())
    if isinstance(value, bytes):
        return np.frombuffer(value, np.uint8)
    return np.zeros(length, kind[0]) if value is None else np.asarray(value, kind[0])
