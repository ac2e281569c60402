"""The lab's topics below its namespace: types, rates, and who publishes them."""

from __future__ import annotations

from typing import NamedTuple

NAMESPACE = "hydrus_xi"


class Topic(NamedTuple):
    """A topic.

    Attributes:
        name: without its namespace; one that begins with "/" has none.
        type: of its messages, as ROS 1 names it.
        rate: at which we publish it, Hz; 0 for whenever there is something to say.
    """

    name: str
    type: str
    rate: float = 0.0

    def full(self, namespace: str) -> str:
        """The whole name."""
        return self.name if self.name.startswith("/") else f"/{namespace.strip('/')}/{self.name}"


_EMPTY, _JOINTS, _POSE = "std_msgs/Empty", "sensor_msgs/JointState", "geometry_msgs/PoseStamped"

ORDERS = tuple(
    Topic(f"teleop_command/{word}", _EMPTY) for word in ("start", "takeoff", "land", "halt", "force_landing")
)
MOCAP, IMU = Topic("mocap/pose", _POSE, 100.0), Topic("imu", "spinal/Imu", 200.0)
JOINT_STATES = Topic("joint_states", _JOINTS, 50.0)
JOINTS_CTRL, GIMBALS_CTRL = Topic("joints_ctrl", _JOINTS, 200.0), Topic("gimbals_ctrl", _JOINTS, 200.0)
SERVO_STATES = Topic("servo/states", "spinal/ServoStates", 50.0)
SERVO_TARGETS = Topic("servo/target_states", "spinal/ServoControlCmd", 50.0)
MOTOR_INFO = Topic("motor_info", "spinal/PwmInfo", 10.0)
UAV_INFO = Topic("uav_info", "spinal/UavInfo", 10.0)
TF = Topic("/tf", "tf2_msgs/TFMessage", 100.0)
FOUR_AXES = Topic("four_axes/command", "spinal/FourAxisCommand", 200.0)
GAINS = Topic("rpy/gain", "spinal/RollPitchYawTerms", 15.0)
P_MATRIX = Topic("p_matrix_pseudo_inverse_inertia", "spinal/PMatrixPseudoInverseWithInertia", 40.0)
DESIRE = Topic("desire_coordinate", "spinal/DesireCoord", 15.0)
CONFIG, ACK = (
    Topic("flight_config_cmd", "spinal/FlightConfigCmd", 40.0),
    Topic("flight_config_cmd_ack", "std_msgs/UInt8"),
)
BATTERY = Topic("battery_voltage_status", "std_msgs/Float32", 10.0)
STATE = Topic("flight_state", "std_msgs/UInt8", 40.0)
COG, BASELINK = (
    Topic("uav/cog/odom", "nav_msgs/Odometry", 100.0),
    Topic("uav/baselink/odom", "nav_msgs/Odometry", 100.0),
)
PID = Topic("debug/pose/pid", "aerial_robot_msgs/PoseControlPid", 40.0)
WRENCH = Topic("estimated_external_wrench", "geometry_msgs/WrenchStamped", 100.0)
NAV = Topic("uav/nav", "aerial_robot_msgs/FlightNav")
TARGET_POSE, TARGET_PATH = Topic("target_pose", _POSE), Topic("target_path", "nav_msgs/Path")
MISSION = Topic("skylimb/mission", "std_msgs/String")
RECORD, SOURCE = (
    Topic("/skylimb/record", "std_msgs/UInt8MultiArray"),
    Topic("/skylimb/source", "std_msgs/UInt8MultiArray"),
)
ROW = Topic("/skylimb/row", "std_msgs/Float64MultiArray", 200.0)
DIAGNOSTICS = Topic("/diagnostics", "diagnostic_msgs/DiagnosticArray", 1.0)

USER = (*ORDERS, TARGET_POSE, TARGET_PATH, NAV, JOINTS_CTRL, MISSION)
"""What a user sends."""

SENSORS = (MOCAP, IMU, JOINT_STATES, SERVO_STATES, ACK, BATTERY)
"""What a robot sends; of each only the first sender is listened to."""

ACTUATORS = (
    *(FOUR_AXES, GAINS, P_MATRIX, DESIRE, CONFIG, MOTOR_INFO, UAV_INFO),
    *(JOINTS_CTRL, GIMBALS_CTRL, SERVO_TARGETS),
)
"""What a controller commands."""

VIEWS = (STATE, COG, BASELINK, TF, PID, WRENCH, ROW, RECORD, SOURCE, DIAGNOSTICS)
"""What anybody may look at."""

_BOARD = (FOUR_AXES, GAINS, P_MATRIX, DESIRE, MOTOR_INFO, UAV_INFO, CONFIG)
_JOINT_COMMANDS = (JOINTS_CTRL, GIMBALS_CTRL)


class Spoken(NamedTuple):
    """Topics of a profile: those it subscribes to, and those it publishes."""

    listens: tuple[Topic, ...]
    says: tuple[Topic, ...]


def spoken(profile: str, servos: bool = False) -> Spoken:
    """What a profile subscribes to and publishes.

    Args:
        profile: simulator, controller or both.
        servos: whether it speaks with the servos in their own counts. Then nobody need translate for
            `controller`, and for `simulator` the lab's `servo_bridge` does.
    """
    if profile == "both":
        seen = (MOCAP, IMU, JOINT_STATES)
        return Spoken((*USER, BATTERY), (*seen, FOUR_AXES, GIMBALS_CTRL, CONFIG, *VIEWS))
    if profile == "simulator":
        states, targets = (
            ((SERVO_STATES,), (SERVO_TARGETS,)) if servos else ((JOINT_STATES,), _JOINT_COMMANDS)
        )
        return Spoken((*_BOARD, *targets), (MOCAP, IMU, *states, ACK, BATTERY, DIAGNOSTICS))
    states, targets = (
        (SERVO_STATES, (SERVO_TARGETS, JOINT_STATES)) if servos else (JOINT_STATES, _JOINT_COMMANDS)
    )
    return Spoken((*USER, MOCAP, IMU, states, ACK, BATTERY), (*_BOARD, *targets, *VIEWS))
