"""The process of ROS 2, which a `Bridge` starts."""

import sys

from skylimb.apps.ros.bridge import main
from skylimb.apps.ros2.connection import Dds

main(sys.argv[1:], Dds)
