"""What the lab's messages hold: signals of a log by the topic that they come on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from skylimb.base.rotations import rotation_from_quaternion, rpy_from_rotation

_Found = list[tuple[str, np.ndarray]]


def reader(topic: str) -> Callable[[Any], _Found] | None:
    """What takes the signals out of a topic's messages, by the end of its name; None for other topics."""
    for ending, read in _READ.items():
        if f"/{topic}".endswith(f"/{ending}"):
            return read
    return None


def stamp(value: Any) -> float:
    """When a message says it was made, s; 0 where it doesn't say."""
    header = getattr(value, "header", value)
    stamp = getattr(header, "stamp", None)
    return 0.0 if stamp is None else stamp.sec + stamp.nanosec * 1e-9


def _xyz(value: Any) -> np.ndarray:
    return np.array([value.x, value.y, value.z])


def _wxyz(value: Any) -> np.ndarray:
    return np.array([value.w, value.x, value.y, value.z])


def _pose(value: Any) -> _Found:
    pose = value.pose
    return [("pose", np.concatenate([_xyz(pose.position), _wxyz(pose.orientation)]))]


def _rates(value: Any) -> _Found:
    return [("gyro", np.asarray(value.gyro))]


def _thrusts(value: Any) -> _Found:
    return [("thrusts", np.asarray(value.base_thrust))]


def _angles(signal: str) -> Callable[[Any], _Found]:
    """Angles by name: a joint is a joint, everything else that is called a gimbal a gimbal."""

    def read(value: Any) -> _Found:
        named = sorted(zip(value.name, value.position, strict=False))
        found = []
        for kind, own in (("joint", "joint"), ("gimbal", "vectoring")):
            angles = [angle for name, angle in named if name.startswith(kind)]
            if angles:
                found.append((f"{own}_{signal}", np.array(angles)))
        return found

    return read


def _odometry(value: Any) -> _Found:
    pose, twist = value.pose.pose, value.twist.twist
    attitude = rpy_from_rotation(rotation_from_quaternion(_wxyz(pose.orientation)))
    return [
        ("cog_position_estimate", _xyz(pose.position)),
        ("cog_velocity_estimate", _xyz(twist.linear)),
        ("attitude_estimate", attitude),
        ("angular_velocity_estimate", _xyz(twist.angular)),
    ]


def _wrench(value: Any) -> _Found:
    wrench = value.wrench
    return [
        ("external_force_estimate", _xyz(wrench.force)),
        ("external_torque_estimate", _xyz(wrench.torque)),
    ]


_READ: dict[str, Callable[[Any], _Found]] = {
    "mocap/pose": _pose,
    "imu": _rates,
    "four_axes/command": _thrusts,
    "joint_states": _angles("measured"),
    "joints_ctrl": _angles("command"),
    "gimbals_ctrl": _angles("command"),
    "uav/cog/odom": _odometry,
    "estimated_external_wrench": _wrench,
}
