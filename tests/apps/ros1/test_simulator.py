"""The profile `simulator` over a real master whose nodes live by `/clock`."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from skylimb.apps.ros1.installation import require_ros

MESSAGES = Path(__file__).parents[2] / "analysis" / "exchange" / "messages"

LOOK = """
import json, time
from skylimb.apps.ros1.installation import require_ros
require_ros()
import rospy
from geometry_msgs.msg import PoseStamped
from rosgraph_msgs.msg import Clock
rospy.init_node("look", anonymous=True, disable_signals=True)
clock, stamps, heard = [], [], {}
rospy.Subscriber("/clock", Clock, lambda one: clock.append(one.clock.to_sec()))
rospy.Subscriber("/hydrus_xi/mocap/pose", PoseStamped, lambda one: stamps.append(one.header.stamp.to_sec()))
for name in ("rpy/pid", "motor_pwms", "imu"):
    count = lambda one, name=name: heard.__setitem__(name, heard.get(name, 0) + 1)
    rospy.Subscriber(f"/hydrus_xi/{name}", rospy.AnyMsg, count)
end = time.monotonic() + 60.0
while time.monotonic() < end and (len(clock) < 400 or len(heard) < 3):
    time.sleep(0.1)
began = rospy.get_time()
print(json.dumps([clock, stamps, heard, began]))
"""


@pytest.mark.slow
def test_nodes_live_by_the_simulators_clock(master: dict[str, str], tmp_path: Path) -> None:
    import rosgraph

    require_ros()
    rosgraph.Master("/test", master["ROS_MASTER_URI"]).setParam("/use_sim_time", True)
    words = [sys.executable, "-m", "skylimb", "ros", "simulator", "--messages", str(MESSAGES)]
    words += ["--start", "joint1=0.5"]
    with (tmp_path / "simulator.log").open("wb") as out:
        simulator = subprocess.Popen(words, env=master, stdout=out, stderr=subprocess.STDOUT)
        try:
            look = [sys.executable, "-c", LOOK]
            seen = subprocess.run(look, env=master, capture_output=True, timeout=120.0, check=True)
        finally:
            simulator.kill()
            simulator.wait()
    clock, stamps, heard, began = json.loads(seen.stdout.splitlines()[-1])
    assert len(clock) >= 400, (tmp_path / "simulator.log").read_text()
    assert set(heard) == {"rpy/pid", "motor_pwms", "imu"}
    # Its time goes on by a period a tick, however busy the machine is; messages are stamped with it.
    steps = np.diff(clock) / 0.005  # ROS may lose a message
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-3)
    assert steps.min() > 0.5
    assert np.mean(steps < 1.5) > 0.9
    assert clock[0] <= began <= clock[-1] + 1.0
    inside = [one for one in stamps if clock[0] <= one <= clock[-1]]
    assert len(inside) > 100
    off = (np.array(inside) - clock[0]) / 0.005
    np.testing.assert_allclose(off, np.round(off), atol=1e-3)
