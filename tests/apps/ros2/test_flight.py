"""A real flight over DDS, judged by ROS 2's own client library."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from skylimb.analysis.exchange.convert import read_log

CLIENT = Path(__file__).parents[2] / "helpers" / "ros2_client.py"
TYPES = {
    "/skylimb/imu": "sensor_msgs/msg/Imu",
    "/skylimb/joint_states": "sensor_msgs/msg/JointState",
    "/skylimb/odom": "nav_msgs/msg/Odometry",
    "/skylimb/cmd_vel": "geometry_msgs/msg/TwistStamped",
    "/skylimb/estimated_external_wrench": "geometry_msgs/msg/WrenchStamped",
    "/skylimb/rotor_thrusts": "skylimb_msgs/msg/RotorThrusts",
    "/skylimb/debug/pose/pid": "skylimb_msgs/msg/PoseTerms",
    "/skylimb/robot_description": "std_msgs/msg/String",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/clock": "rosgraph_msgs/msg/Clock",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
}


@pytest.mark.slow
def test_rclpy_arms_flies_a_square_and_lands(
    rclpy_python: str, domain: dict[str, str], tmp_path: Path
) -> None:
    words = [sys.executable, "-m", "skylimb", "ros2", "both", "--controller", "hybrid"]
    log = tmp_path / "node.log"
    with log.open("wb") as said:
        node = subprocess.Popen(
            [*words, "--out", str(tmp_path / "out")], env=domain, stdout=said, stderr=subprocess.STDOUT
        )
        own = {name: value for name, value in domain.items() if name != "PYTHONPATH"}
        client = [rclpy_python, str(CLIENT), "skylimb", "-0.25", str(tmp_path / "seen.json")]
        flown = subprocess.run(client, env=own, capture_output=True, text=True, timeout=300, check=False)
        node.send_signal(signal.SIGINT)
        node.wait(120)
    assert flown.returncode == 0, flown.stdout + flown.stderr + log.read_text(encoding="utf-8")
    seen = json.loads((tmp_path / "seen.json").read_text(encoding="utf-8"))
    assert [state for state in seen["states"] if state not in (1, 6)] == [0, 2, 3, 5, 4, 0]
    np.testing.assert_allclose(seen["reached"], seen["corners"], atol=0.05)
    assert TYPES.items() <= {name: kinds[0] for name, kinds in seen["types"].items()}.items()
    assert seen["frames"] == {"odom": "flight_controller", "cog/odom": "cog"}
    assert seen["joints"][-1] == "gimbal_joint4"
    assert seen["urdf"].startswith("<?xml")
    assert min(seen["counts"][name] for name in ("imu", "mocap/pose", "/clock", "/diagnostics")) > 5
    (record,) = (tmp_path / "out").glob("*-flight.nc")
    assert read_log(record).run.log.sizes["time"] > 1000
    assert "Traceback" not in log.read_text(encoding="utf-8")
