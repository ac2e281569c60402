"""A publisher that means no good, as a program: `flood`, `md5` or `battery`, for fifteen seconds."""

from __future__ import annotations

import sys
import time

from skylimb.apps.ros1.installation import require_ros

require_ros()

import rospy  # noqa: E402
from geometry_msgs.msg import PoseStamped  # noqa: E402
from std_msgs.msg import Float32, String  # noqa: E402


def main(what: str) -> None:
    rospy.init_node("hostile", anonymous=True, disable_signals=True)
    if what == "flood":
        topic, kind, pause = "target_pose", PoseStamped, 0.0
    elif what == "md5":
        topic, kind, pause = "uav/nav", String, 0.05
    else:
        topic, kind, pause = "battery_voltage_status", Float32, 0.1
    publisher = rospy.Publisher(f"/hydrus_xi/{topic}", kind, queue_size=1000)
    message = kind(25.0) if kind is Float32 else kind()
    while not publisher.get_num_connections():
        time.sleep(0.05)
    end = time.monotonic() + 15.0
    while time.monotonic() < end:
        publisher.publish(message)
        time.sleep(pause)


main(sys.argv[1])
