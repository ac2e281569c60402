"""A client of the lab's topics, as a program: up, somewhere, a mission, down; says what it saw.

python lab_client.py MISSION OUT.json
"""

from __future__ import annotations

import json
import math
import sys
import time
from pathlib import Path
from typing import Any

from skylimb.apps.ros1.installation import require_ros

require_ros()

import rospy  # noqa: E402
from geometry_msgs.msg import PoseStamped  # noqa: E402
from nav_msgs.msg import Odometry  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from std_msgs.msg import Empty, String, UInt8  # noqa: E402
from tf2_msgs.msg import TFMessage  # type: ignore  # noqa: E402

NAMESPACE = "/hydrus_xi"


class Client:
    """What the lab's own client does, with its thresholds."""

    def __init__(self) -> None:
        rospy.init_node("client", anonymous=True)
        self.state, self.odom, self.joints = -1, None, None
        self.states: list[int] = []
        self.frames: dict[str, str] = {}
        for topic in ("/tf", "/tf_static"):
            rospy.Subscriber(topic, TFMessage, self._tf)
        rospy.Subscriber(f"{NAMESPACE}/flight_state", UInt8, self._state)
        rospy.Subscriber(f"{NAMESPACE}/uav/cog/odom", Odometry, self._odom)
        rospy.Subscriber(f"{NAMESPACE}/joint_states", JointState, self._joints)
        self._orders = {
            word: rospy.Publisher(f"{NAMESPACE}/teleop_command/{word}", Empty, queue_size=1)
            for word in ("start", "takeoff", "land", "halt", "force_landing")
        }
        self._pose = rospy.Publisher(f"{NAMESPACE}/target_pose", PoseStamped, queue_size=1)
        self._joints_ctrl = rospy.Publisher(f"{NAMESPACE}/joints_ctrl", JointState, queue_size=1)
        self._mission = rospy.Publisher(f"{NAMESPACE}/skylimb/mission", String, queue_size=1)
        self.until(
            lambda: self.state >= 0 and self.odom is not None and self.joints is not None, 20.0, "topics"
        )
        publishers = [*self._orders.values(), self._pose, self._joints_ctrl, self._mission]
        self.until(lambda: all(one.get_num_connections() for one in publishers), 10.0, "subscribers")

    def _state(self, message: Any) -> None:
        self.state = message.data
        if not self.states or self.states[-1] != message.data:
            self.states.append(message.data)

    def _tf(self, message: Any) -> None:
        for one in message.transforms:
            self.frames[one.child_frame_id] = one.header.frame_id

    def _odom(self, message: Any) -> None:
        self.odom = message

    def _joints(self, message: Any) -> None:
        self.joints = dict(zip(message.name, message.position, strict=True))

    def until(self, done: Any, seconds: float, what: str) -> None:
        end = time.monotonic() + seconds
        while not done():
            if time.monotonic() > end:
                raise SystemExit(f"no {what} within {seconds} s; state {self.state}")
            time.sleep(0.05)

    def order(self, word: str) -> None:
        self._orders[word].publish()

    def position(self) -> tuple[float, float, float]:
        place: Any = self.odom
        point = place.pose.pose.position
        return point.x, point.y, point.z

    def go(self, x: float, y: float, z: float, seconds: float = 30.0) -> None:
        message, here = PoseStamped(), self.odom
        message.header.stamp = rospy.Time.now()
        message.pose.position.x, message.pose.position.y, message.pose.position.z = x, y, z
        yaw = self.yaw_of_baselink
        message.pose.orientation.z, message.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
        self._pose.publish(message)
        assert here is not None

        def there() -> bool:
            speed = self.odom.twist.twist.linear  # type: ignore[union-attr]
            near = max(abs(a - b) for a, b in zip(self.position(), (x, y, z), strict=True)) < 0.1
            return near and max(abs(speed.x), abs(speed.y), abs(speed.z)) < 0.05

        self.until(there, seconds, "arrival")

    @property
    def yaw_of_baselink(self) -> float:
        turn = rospy.wait_for_message(f"{NAMESPACE}/uav/baselink/odom", Odometry, 5.0).pose.pose.orientation
        return math.atan2(
            2 * (turn.w * turn.z + turn.x * turn.y), 1 - 2 * (turn.y * turn.y + turn.z * turn.z)
        )

    def pose_joints(self, **angles: float) -> None:
        message = JointState()
        message.header.stamp = rospy.Time.now()
        message.name, message.position = list(angles), list(angles.values())
        self._joints_ctrl.publish(message)
        self.until(lambda: all(abs(self.joints[k] - v) < 0.08 for k, v in angles.items()), 15.0, "posture")  # type: ignore[index]

    def fly(self, name: str) -> None:
        self._mission.publish(name)


def main(mission: str, seconds: float, out: Path) -> None:
    client = Client()
    client.order("start")
    client.until(lambda: client.state == 2, 5.0, "ARM_ON")
    client.order("takeoff")
    client.until(lambda: client.state == 5, 30.0, "HOVER")
    client.order("takeoff")  # the original stops its motors here
    client.order("start")
    x, y, z = client.position()
    client.go(x - 0.3, y + 0.2, z + 0.3)
    moved = client.position()
    # The presets with vectoring angles for contact bend the arm to the other side.
    side = math.copysign(1.0, (client.joints or {"joint1": 1.0})["joint1"])
    client.pose_joints(joint1=side * 0.87, joint2=side * 1.4, joint3=side * -0.7)
    posed = dict(client.joints or {})
    client.fly(mission)
    time.sleep(seconds)
    client.order("land")
    client.until(lambda: client.state == 0, 30.0, "ARM_OFF")
    seen = {"states": client.states, "moved": moved, "posed": posed, "frames": client.frames}
    out.write_text(json.dumps(seen), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]), Path(sys.argv[3]))
