"""A client on ROS 2, a program for a Python with rclpy: up, a square by set points, down; says what it saw.

python ros2_client.py NAMESPACE SIDE OUT.json
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import rclpy  # type: ignore[import-not-found]
from diagnostic_msgs.msg import DiagnosticArray  # type: ignore[import-not-found]
from geometry_msgs.msg import PoseStamped  # type: ignore[import-not-found]
from nav_msgs.msg import Odometry  # type: ignore[import-not-found]
from rclpy.qos import (  # type: ignore[import-not-found]
    DurabilityPolicy,
    QoSProfile,
    qos_profile_sensor_data,
)
from rosgraph_msgs.msg import Clock  # type: ignore[import-not-found]
from sensor_msgs.msg import Imu, JointState  # type: ignore[import-not-found]
from std_msgs.msg import Empty, String, UInt8  # type: ignore[import-not-found]

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Client:
    """Keeps the last message of each topic, and how many came."""

    def __init__(self, namespace: str) -> None:
        rclpy.init()
        self.node = rclpy.create_node("client")
        self.last: dict[str, Any] = {}
        self.counts: dict[str, int] = {}
        self.states: list[int] = []
        self._at = f"/{namespace}/"
        for kind, name, qos in (
            (UInt8, "flight_state", 10),
            (Odometry, "cog/odom", 10),
            (Odometry, "odom", 10),
            (JointState, "joint_states", 10),
            (Imu, "imu", qos_profile_sensor_data),
            (PoseStamped, "mocap/pose", qos_profile_sensor_data),
            (String, "robot_description", LATCHED),
            (DiagnosticArray, "/diagnostics", 10),
            (Clock, "/clock", 10),
        ):
            whole = name if name.startswith("/") else self._at + name
            self.node.create_subscription(kind, whole, lambda one, name=name: self._take(name, one), qos)
        self.orders = {
            word: self.node.create_publisher(Empty, f"{self._at}teleop_command/{word}", 10)
            for word in ("start", "takeoff", "land", "halt")
        }
        self.target = self.node.create_publisher(PoseStamped, f"{self._at}target_pose", 10)
        publishers = (*self.orders.values(), self.target)
        self.until(lambda: all(one.get_subscription_count() for one in publishers), "subscribers")
        self.until(lambda: {"flight_state", "cog/odom"} <= self.last.keys(), "topics")

    def _take(self, name: str, message: Any) -> None:
        self.last[name], self.counts[name] = message, self.counts.get(name, 0) + 1
        if name == "flight_state" and self.states[-1:] != [message.data]:
            self.states.append(message.data)

    def until(self, done: Any, what: str, seconds: float = 60.0) -> None:
        end = time.monotonic() + seconds
        while not done():
            rclpy.spin_once(self.node, timeout_sec=0.05)
            if time.monotonic() > end:
                raise SystemExit(f"no {what} within {seconds} s; states {self.states}")

    def order(self, word: str, state: int) -> None:
        """Order, and wait for the state that it leads to."""
        self.orders[word].publish(Empty())
        self.until(lambda: self.states[-1] == state, word)

    @property
    def position(self) -> tuple[float, float, float]:
        point = self.last["cog/odom"].pose.pose.position
        return point.x, point.y, point.z

    def go(self, *place: float) -> tuple[float, float, float]:
        """Fly to a place, W, m, with the yaw of the odometry; where it then is."""
        message = PoseStamped()
        message.header.frame_id, message.pose.orientation = "world", self.last["odom"].pose.pose.orientation
        message.pose.orientation.x = message.pose.orientation.y = 0.0
        point = message.pose.position
        point.x, point.y, point.z = place
        self.target.publish(message)

        def there() -> bool:
            speed = self.last["cog/odom"].twist.twist.linear
            near = max(abs(a - b) for a, b in zip(self.position, place, strict=True)) < 0.05
            return near and max(abs(speed.x), abs(speed.y), abs(speed.z)) < 0.03

        self.until(there, f"arrival at {place}")
        return self.position


def main(namespace: str, side: float, out: Path) -> None:
    client = Client(namespace)
    client.order("start", 2)
    client.order("takeoff", 5)
    x, y, z = client.position
    corners = [(x + side, y, z), (x + side, y + side, z), (x, y + side, z), (x, y, z)]
    reached = [client.go(*corner) for corner in corners]
    client.order("land", 0)
    names = {name: sorted(kinds) for name, kinds in client.node.get_topic_names_and_types()}
    joints = client.last["joint_states"].name
    seen = {"states": client.states, "corners": corners, "reached": reached, "counts": client.counts}
    seen |= {"types": names, "joints": joints, "urdf": client.last["robot_description"].data}
    seen |= {"frames": {name: client.last[name].child_frame_id for name in ("odom", "cog/odom")}}
    out.write_text(json.dumps(seen), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]), Path(sys.argv[3]))
