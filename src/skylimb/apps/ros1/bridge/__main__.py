"""The bridge's process, which a `Bridge` starts."""

import sys

from skylimb.apps.ros1.bridge.process import main

main(sys.argv[1:])
