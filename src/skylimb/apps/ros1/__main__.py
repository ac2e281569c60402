"""The process of ROS 1, which a `Bridge` starts."""

import sys

from skylimb.apps.ros.bridge import main
from skylimb.apps.ros1.connection import Rospy

main(sys.argv[1:], Rospy)
