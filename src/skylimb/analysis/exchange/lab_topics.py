"""The one table of topics: what the node hears and publishes, and what logs are written and read by."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any

from skylimb.analysis.exchange import lab_messages as made
from skylimb.analysis.exchange.lab_ticks import TickView
from skylimb.base.errors import ConfigError

NAMESPACE = "hydrus_xi"
"""Of the lab's topics; the flight computer's stack is started in it."""

_NAMESPACE = re.compile(r"/?[A-Za-z][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*/?")


def require_namespace(namespace: str) -> None:
    """Check that ROS takes a namespace of topics.

    Raises:
        ConfigError: when it does not.
    """
    if not _NAMESPACE.fullmatch(namespace):
        raise ConfigError(
            f"--namespace = '{namespace}' is no namespace of ROS: letters, digits and _, with single /, "
            "for example lab/hydrus_xi"
        )


@dataclass(frozen=True, eq=False)
class Topic:
    """A topic of the lab, or of ours.

    Attributes:
        name: without its namespace; one that begins with "/" has none.
        type: of its messages.
        rate: at which it is published, Hz; 0 for whenever there is something to say.
        make: the message of a tick; None for what is made elsewhere, or only listened to.
        needs: signals of a log that this takes; none for what no log is written with.
        signals: that a log is read with, by the paths of their fields in the message.
        latched: whether who comes later still gets the last message.
        called: by which it goes where that is not its name.
    """

    name: str
    type: str
    rate: float = 0.0
    make: Callable[[TickView], Any] | None = None
    needs: tuple[str, ...] = ()
    signals: Mapping[str, str] = field(default_factory=dict)
    latched: bool = False
    called: str = ""

    def full(self, namespace: str) -> str:
        """The whole name."""
        name = self.called or self.name
        return name if name.startswith("/") else f"/{namespace.strip('/')}/{name}"


_EMPTY, _POSE, _ODOMETRY = "std_msgs/msg/Empty", "geometry_msgs/msg/PoseStamped", "nav_msgs/msg/Odometry"
_JOINTS, _WRENCH = "sensor_msgs/msg/JointState", "geometry_msgs/msg/WrenchStamped"
_BYTES = "std_msgs/msg/UInt8MultiArray"

_ANGLES = ("joint_angles_measured", "vectoring_angles_measured")
_POSED = ("root_position_measured", "root_quaternion_measured", *_ANGLES)
_ESTIMATE = {"external_force_estimate": "wrench.force", "external_torque_estimate": "wrench.torque"}
_CONTACT = ("contact_force", "contact_torque")
_COG = {
    "cog_position_estimate": "pose.pose.position",
    "cog_velocity_estimate": "twist.twist.linear",
    "attitude_estimate": "pose.pose.orientation",
    "angular_velocity_estimate": "twist.twist.angular",
}

ORDERS = tuple(
    Topic(f"teleop_command/{word}", _EMPTY) for word in ("start", "takeoff", "land", "halt", "force_landing")
)
MOCAP = Topic("mocap/pose", _POSE, 100.0, made.mocap, _POSED, {"pose": "pose"})
IMU = Topic(
    "imu", "spinal/msg/Imu", 200.0, made.imu, (*_POSED, "root_angular_velocity_measured"),
    {"gyro": "gyro", "acc": "acc"},
)  # fmt: skip
JOINT_STATES = Topic("joint_states", _JOINTS, 50.0, made.joint_states, _ANGLES, {"measured": ""})
FOUR_AXES = Topic(
    "four_axes/command", "spinal/msg/FourAxisCommand", 200.0, made.four_axes, ("thrusts_command",),
    {"thrusts_command": "base_thrust"},
)  # fmt: skip
JOINTS_CTRL = Topic(
    "joints_ctrl", _JOINTS, 200.0, made.joints_ctrl, ("joint_angles_command",), {"command": ""}
)
GIMBALS_CTRL = Topic(
    "gimbals_ctrl", _JOINTS, 200.0, made.gimbals_ctrl, ("vectoring_angles_command",), {"command": ""}
)
COG = Topic(
    "uav/cog/odom", _ODOMETRY, 100.0, made.cog_odometry, (*_COG, *_POSED),
    _COG,
)  # fmt: skip
BASELINK = Topic("uav/baselink/odom", _ODOMETRY, 100.0, made.baselink_odometry)
FULL_STATE = Topic("uav/full_state", "aerial_robot_msgs/msg/States", 100.0, made.full_state)
WRENCH = Topic(
    "estimated_external_wrench", _WRENCH, 100.0, made.wrench(*_ESTIMATE), tuple(_ESTIMATE), _ESTIMATE
)
CONTACT = Topic("skylimb/contact_wrench", _WRENCH, 100.0, made.wrench(*_CONTACT), _CONTACT)
REFERENCE = Topic(
    "skylimb/cog_reference", "geometry_msgs/msg/PointStamped", 100.0, made.cog_reference,
    ("cog_position_reference",),
)  # fmt: skip
TF = Topic("/tf", "tf2_msgs/msg/TFMessage", 100.0, made.transforms)
TF_STATIC = Topic("/tf_static", TF.type, 1.0, made.mounts, latched=True)
CLOCK = Topic("/clock", "rosgraph_msgs/msg/Clock", 200.0, lambda tick: {"clock": tick.stamp})
STATE = Topic("flight_state", "std_msgs/msg/UInt8", 40.0, attrgetter("state"))
PID = Topic("debug/pose/pid", "aerial_robot_msgs/msg/PoseControlPid", 40.0, made.pose_errors)
CONFIG = Topic("flight_config_cmd", "spinal/msg/FlightConfigCmd", 40.0, attrgetter("arming"))
ACK = Topic("flight_config_ack", "std_msgs/msg/UInt8")
PWMS = Topic("motor_pwms", "spinal/msg/Pwms", 10.0)
RPY_PID = Topic("rpy/pid", "spinal/msg/RollPitchYawTerms", 10.0)
SERVO_TORQUE = Topic("servo/torque_enable", "spinal/msg/ServoTorqueCmd")
JOINTS_TORQUE, GIMBALS_TORQUE = (
    Topic(f"{group}/torque_enable", "std_srvs/srv/SetBool") for group in ("joints", "gimbals")
)
"""Services of the lab's servo_bridge."""

SERVO_STATES = Topic("servo/states", "spinal/msg/ServoStates", 50.0)
SERVO_TARGETS = Topic("servo/target_states", "spinal/msg/ServoControlCmd", 50.0)
MOTOR_INFO, UAV_INFO = (
    Topic("motor_info", "spinal/msg/PwmInfo", 10.0),
    Topic("uav_info", "spinal/msg/UavInfo", 10.0),
)
GAINS = Topic("rpy/gain", "spinal/msg/RollPitchYawTerms", 15.0)
P_MATRIX = Topic("p_matrix_pseudo_inverse_inertia", "spinal/msg/PMatrixPseudoInverseWithInertia", 40.0)
TORQUE_INVERSE = Topic("torque_allocation_matrix_inv", "spinal/msg/TorqueAllocationMatrixInv")
GIMBAL_DOF = Topic("gimbal_dof", "std_msgs/msg/UInt8")
DESIRE = Topic("desire_coordinate", "spinal/msg/DesireCoord", 15.0)
BATTERY = Topic("battery_voltage_status", "std_msgs/msg/Float32", 10.0)
NAV = Topic("uav/nav", "aerial_robot_msgs/msg/FlightNav")
TARGET_POSE, TARGET_PATH = Topic("target_pose", _POSE), Topic("target_path", "nav_msgs/msg/Path")
JOY = Topic("joy", "sensor_msgs/msg/Joy")
MISSION = Topic("skylimb/mission", "std_msgs/msg/String")
RECORD, SOURCE = (Topic(f"/skylimb/{name}", _BYTES, latched=True) for name in ("record", "source"))
ROW = Topic("/skylimb/row", "std_msgs/msg/Float64MultiArray", 200.0)
DIAGNOSTICS = Topic("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", 1.0)

FOREIGN = "skylimb/foreign"
"""No topic: under this name the bridge says who else publishes on a command's."""

IN_LOGS = (
    *(MOCAP, IMU, JOINT_STATES, FOUR_AXES, JOINTS_CTRL, GIMBALS_CTRL, COG, WRENCH, CONTACT, REFERENCE),
)
"""What a log is written with, and read by where skylimb did not write it."""

EACH_TICK = (MOCAP, FOUR_AXES, JOINTS_CTRL, GIMBALS_CTRL)
"""Of a log whatever its rate: all commands, and every new frame of the motion capture."""

USER = (*ORDERS, TARGET_POSE, TARGET_PATH, NAV, JOINTS_CTRL, MISSION, JOY)
"""What a user sends."""

SENSORS = (MOCAP, IMU, JOINT_STATES, SERVO_STATES, ACK, PWMS, BATTERY)
"""What a robot sends; of each only the first sender is listened to."""

ACTUATORS = (
    *(FOUR_AXES, GAINS, P_MATRIX, TORQUE_INVERSE, DESIRE, CONFIG, MOTOR_INFO, UAV_INFO),
    *(JOINTS_CTRL, GIMBALS_CTRL, SERVO_TARGETS),
)
"""What a controller commands."""

VIEWS = (STATE, COG, BASELINK, FULL_STATE, TF, TF_STATIC, PID, WRENCH, ROW, RECORD, SOURCE, DIAGNOSTICS)
"""What anybody may look at."""


def is_due(topic: Topic, k: int, period: float) -> bool:
    """Whether a topic is published at tick `k`: at its own rate, or at each tick, `period` s apart."""
    return k % (1 if topic.rate <= 0.0 else max(1, round(1.0 / (topic.rate * period)))) == 0
