"""The bridge's process, which `start_bridge` starts."""

import sys

from skylimb.apps.ros1.rim.bridge import main

main(sys.argv[1:])
