"""The lab's topics out of a run: poses and imu, joints, commands, estimates.

Frames and units are those of the lab's own messages: quaternions x y z w; linear velocity of an odometry in
the world, angular velocity in the body; a wrench with its force in the world and its torque about the centre
of gravity.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from skylimb.analysis.exchange.frames import from_measured_link, lab_turn_in_C
from skylimb.analysis.exchange.message_types import FOUR_AXES, IMU
from skylimb.robots.model import Robot

WORLD = "world"
SAME_POSE = 1e-9
"""Metres, or parts of a quaternion, by which a pose that is held may be off by rounding."""

NAMESPACE = "hydrus_xi"
"""Of the lab's topics; the flight computer's stack is started in it."""

POSE, ODOMETRY = "geometry_msgs/msg/PoseStamped", "nav_msgs/msg/Odometry"
JOINTS, WRENCH = "sensor_msgs/msg/JointState", "geometry_msgs/msg/WrenchStamped"
POINT = "geometry_msgs/msg/PointStamped"


class Topic(NamedTuple):
    """A topic of the lab.

    Attributes:
        name: without its namespace.
        type: of its messages.
        rate: Hz at most.
        needs: signals of a log that it is made of.
        make: from these signals at a tick to the message; None where there is nothing new to say.
        content: a few words.
    """

    name: str
    type: str
    rate: float
    needs: tuple[str, ...]
    make: Callable[[Builder, int], Any]
    content: str


class Builder:
    """Makes the messages of a run's ticks.

    Args:
        log: of the run.
        robot: that flew.
        types: message classes.
        start: time of the first row, ns.
        link: whose pose is on the lab's topics.
        namespace: of the lab's topics, and of its frames.
    """

    def __init__(
        self, log: xr.Dataset, robot: Robot, types: Any, start: int, link: str, namespace: str
    ) -> None:
        self.namespace = namespace.strip("/")
        self._types, self.robot, self.link = types.types, robot, link
        self.values = {str(name): np.asarray(log[name].values) for name in log.variables}
        self.times = start + np.round((log.time.values - log.time.values[0]) * 1e9).astype(np.int64)
        description = robot.description
        self.joints = list(description.shape_joints)
        # The lab's gimbals are ours under another name, with the same zero and axis.
        self.vectoring = [name.replace("gimbal_joint", "gimbal") for name in description.vectoring_joints]
        self._shown, self._posed = np.full(7, np.nan), (-1, (np.zeros(3), np.eye(3), np.eye(3)))

    def of(self, kind: str, /, **fields: Any) -> Any:
        """A message."""
        return self._types[kind](**fields)

    def stamp(self, k: int) -> Any:
        """The time of a tick."""
        seconds, rest = divmod(int(self.times[k]), 10**9)
        return self.of("builtin_interfaces/msg/Time", sec=seconds, nanosec=rest)

    def header(self, k: int, frame: str = WORLD) -> Any:
        """A header with a tick's time."""
        return self.of("std_msgs/msg/Header", seq=k, stamp=self.stamp(k), frame_id=frame)

    def vector(self, values: np.ndarray, kind: str = "Vector3") -> Any:
        """A vector, or a point."""
        x, y, z = map(float, values)
        return self.of(f"geometry_msgs/msg/{kind}", x=x, y=y, z=z)

    def pose(self, position: np.ndarray, R: np.ndarray) -> Any:
        """A pose of an orientation matrix."""
        from skylimb.base.rotations import quaternion_from_rotation

        w, x, y, z = map(float, quaternion_from_rotation(R))
        turn = self.of("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)
        return self.of("geometry_msgs/msg/Pose", position=self.vector(position, "Point"), orientation=turn)

    def joint_state(self, k: int, names: list[str], angles: np.ndarray) -> Any:
        """Named angles, rad."""
        nothing = np.zeros(0)
        return self.of(
            JOINTS, header=self.header(k, ""), name=names, position=angles, velocity=nothing, effort=nothing
        )

    def lab_pose(self, k: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Position and orientation of the lab's link in W as measured, and its axes in the measured link."""
        from skylimb.base.rotations import rotation_from_quaternion

        if self._posed[0] == k:
            return self._posed[1]
        values = self.values
        xyz, turn = from_measured_link(
            self.robot,
            self.link,
            values["joint_angles_measured"][k],
            values["vectoring_angles_measured"][k],
        )
        R = rotation_from_quaternion(values["root_quaternion_measured"][k])
        self._posed = k, (values["root_position_measured"][k] + R @ xyz, R @ turn, turn)
        return self._posed[1]

    def lab_turn_in_C(self, k: int) -> np.ndarray:
        """The lab's axes at the centre of gravity, in C of the measured posture, (3, 3)."""
        q, psi = (self.values[f"{name}_angles_measured"][k] for name in ("joint", "vectoring"))
        return lab_turn_in_C(self.robot, self.link, q, psi)

    def is_new_frame(self, k: int) -> bool:
        """Whether motion capture shows another pose than at the tick before."""
        seen = np.concatenate(
            [self.values["root_position_measured"][k], self.values["root_quaternion_measured"][k]]
        )
        fresh = not np.all(abs(seen - self._shown) < SAME_POSE)
        self._shown = seen
        return fresh


def _mocap(b: Builder, k: int) -> Any:
    if not b.is_new_frame(k):
        return None
    position, R, _ = b.lab_pose(k)
    return b.of(POSE, header=b.header(k), pose=b.pose(position, R))


def _imu(b: Builder, k: int) -> Any:
    _, R, turn = b.lab_pose(k)
    q = b.pose(np.zeros(3), R).orientation
    return b.of(
        IMU,
        stamp=b.stamp(k),
        acc=np.full(3, np.nan, np.float32),
        gyro=(turn.T @ b.values["root_angular_velocity_measured"][k]).astype(np.float32),
        mag=np.full(3, np.nan, np.float32),
        quaternion=np.array([q.x, q.y, q.z, q.w], np.float32),
    )


def _joint_states(b: Builder, k: int) -> Any:
    angles = [b.values[f"{name}_angles_measured"][k] for name in ("joint", "vectoring")]
    return b.joint_state(k, [*b.joints, *b.vectoring], np.concatenate(angles))


def _four_axes(b: Builder, k: int) -> Any:
    thrusts = b.values["thrusts_command"][k].astype(np.float32)
    return b.of(FOUR_AXES, angles=np.zeros(3, np.float32), base_thrust=thrusts)


def _joints_ctrl(b: Builder, k: int) -> Any:
    return b.joint_state(k, b.joints, b.values["joint_angles_command"][k])


def _gimbals_ctrl(b: Builder, k: int) -> Any:
    return b.joint_state(k, b.vectoring, b.values["vectoring_angles_command"][k])


def _cog_odometry(b: Builder, k: int) -> Any:
    from skylimb.base.rotations import rotation_from_rpy

    turn = b.lab_turn_in_C(k)
    R = rotation_from_rpy(*b.values["attitude_estimate"][k]) @ turn
    velocity = b.values["cog_velocity_estimate"][k]
    return _odometry(
        b, k, f"{b.namespace}/cog", b.pose(b.values["cog_position_estimate"][k], R), velocity,
        turn.T @ b.values["angular_velocity_estimate"][k],
    )  # fmt: skip


def _odometry(b: Builder, k: int, child: str, pose: Any, velocity: np.ndarray, turning: np.ndarray) -> Any:
    unknown = np.zeros(36)
    twist = b.of("geometry_msgs/msg/Twist", linear=b.vector(velocity), angular=b.vector(turning))
    return b.of(
        ODOMETRY,
        header=b.header(k),
        child_frame_id=child,
        pose=b.of("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=unknown),
        twist=b.of("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=unknown),
    )


def _wrench(force: str, torque: str) -> Callable[[Builder, int], Any]:
    def make(b: Builder, k: int) -> Any:
        parts = {"force": b.vector(b.values[force][k]), "torque": b.vector(b.values[torque][k])}
        return b.of(WRENCH, header=b.header(k), wrench=b.of("geometry_msgs/msg/Wrench", **parts))

    return make


def _reference(b: Builder, k: int) -> Any:
    return b.of(POINT, header=b.header(k), point=b.vector(b.values["cog_position_reference"][k], "Point"))


_POSE = (
    "root_position_measured",
    "root_quaternion_measured",
    "joint_angles_measured",
    "vectoring_angles_measured",
)
_COG = ("cog_position_estimate", "cog_velocity_estimate", "attitude_estimate", "angular_velocity_estimate")
_EVERY = 1e9

TOPICS = (
    Topic("mocap/pose", POSE, _EVERY, _POSE, _mocap, "pose of the flight controller, new frames"),
    Topic(
        "imu", IMU, 200.0, (*_POSE, "root_angular_velocity_measured"), _imu,
        "attitude and rates of the flight controller, without acceleration",
    ),
    Topic("joint_states", JOINTS, 50.0, _POSE[2:], _joint_states, "joints and gimbals, rad"),
    Topic("four_axes/command", FOUR_AXES, _EVERY, ("thrusts_command",), _four_axes, "thrusts, N"),
    Topic("joints_ctrl", JOINTS, _EVERY, ("joint_angles_command",), _joints_ctrl, "commanded joints, rad"),
    Topic("gimbals_ctrl", JOINTS, _EVERY, ("vectoring_angles_command",), _gimbals_ctrl, "gimbals likewise"),
    Topic(
        "uav/cog/odom", ODOMETRY, 100.0,
        (*_COG, *_POSE),
        _cog_odometry, "estimated centre of gravity; velocity in the world, rates in the body",
    ),
    Topic(
        "estimated_external_wrench", WRENCH, 100.0, ("external_force_estimate", "external_torque_estimate"),
        _wrench("external_force_estimate", "external_torque_estimate"),
        "force in the world, torque about the centre of gravity",
    ),
    Topic(
        "skylimb/contact_wrench", WRENCH, 100.0, ("contact_force", "contact_torque"),
        _wrench("contact_force", "contact_torque"), "the true one, of a simulated flight",
    ),
    Topic(
        "skylimb/cog_reference", POINT, 100.0, ("cog_position_reference",), _reference,
        "the mission's centre of gravity",
    ),
)  # fmt: skip


def topics_of(log: xr.Dataset) -> list[Topic]:
    """The topics that a log has all signals for."""
    return [topic for topic in TOPICS if all(name in log.variables for name in topic.needs)]


def ticks_of(topic: Topic, times: np.ndarray) -> Iterator[int]:
    """The ticks at which a topic's rate allows a message; times in ns."""
    last = -np.inf
    for k, time in enumerate(times):
        if time - last >= (1.0 / topic.rate - 1e-4) * 1e9:
            last = time
            yield k
