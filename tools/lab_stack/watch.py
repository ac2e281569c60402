"""Listens to a flight of the lab's stack, for the Python of ROS: `watch.py NAMESPACE OUT.json`.

Until it is ended it keeps the errors that the lab's own controller states while it hovers, and writes them by
the posture that was last asked for: the greatest of all, and the greatest of the last second before the next.
"""

import json
import signal
import sys

import rospy
from aerial_robot_msgs.msg import PoseControlPid  # type: ignore[import-not-found]
from sensor_msgs.msg import JointState
from std_msgs.msg import UInt8

HOVER, STANDS = 5, 1.0
AXES = ("x", "y", "z", "yaw")


class Watch:
    """What came of a flight so far."""

    def __init__(self, namespace):
        self.state, self.states, self.rows = -1, [], []
        self.postures, self.joints = [], {}
        rospy.Subscriber(namespace + "/flight_state", UInt8, self.on_state)
        rospy.Subscriber(namespace + "/joints_ctrl", JointState, self.on_posture)
        rospy.Subscriber(namespace + "/joint_states", JointState, self.on_joints)
        rospy.Subscriber(namespace + "/debug/pose/pid", PoseControlPid, self.on_errors)

    def on_state(self, message):
        """Of the flight."""
        if message.data != self.state:
            self.state = message.data
            self.states.append(message.data)

    def on_posture(self, message):
        """That is asked for."""
        self.postures.append(list(message.position))

    def on_joints(self, message):
        """As measured."""
        self.joints = dict(zip(message.name, message.position, strict=False))

    def on_errors(self, message):
        """As the controller states them."""
        if self.state == HOVER:
            errors = [getattr(message, axis).err_p for axis in AXES]
            now = [self.joints.get(f"joint{i + 1}", 0.0) for i in range(3)]
            self.rows.append((message.header.stamp.to_sec(), len(self.postures), errors, now))

    def report(self):
        """By posture."""
        found = []
        for k in sorted({row[1] for row in self.rows}):
            rows = [row for row in self.rows if row[1] == k]
            last = [row for row in rows if row[0] > rows[-1][0] - STANDS]
            found.append(
                {
                    "asked": self.postures[k - 1] if k else None,
                    "joints": last[-1][3],
                    "worst": [max(abs(row[2][i]) for row in rows) for i in range(4)],
                    "standing": [max(abs(row[2][i]) for row in last) for i in range(4)],
                    "seconds": rows[-1][0] - rows[0][0],
                }
            )
        return {"states": self.states, "postures": found}


def main(namespace, out):
    """Listen until it is ended."""
    rospy.init_node("watch", disable_signals=True)
    watch = Watch(namespace)
    signal.sigwait({signal.SIGINT, signal.SIGTERM})
    with open(out, "w") as file:
        json.dump(watch.report(), file)
    rospy.signal_shutdown("done")


if __name__ == "__main__":
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    main(*sys.argv[1:])
