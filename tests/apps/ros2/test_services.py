"""Services of a node beside which a ROS 2 is sourced, asked by ROS 2's own client library."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

CLIENT = Path(__file__).parents[2] / "helpers" / "ros2_services.py"


def sourced(python: str) -> dict[str, str]:
    """What sourcing adds to an environment, of a Python that has ROS 2's wheels."""
    code = "import rclpy, pathlib; print(pathlib.Path(rclpy.__file__).parents[1])"
    place = subprocess.run([python, "-c", code], capture_output=True, text=True, check=True).stdout.strip()
    libraries = [str(path) for path in Path(place).glob("ros_*.libs")]
    return {
        "PYTHONPATH": os.pathsep.join([*filter(None, sys.path), place]),
        "LD_LIBRARY_PATH": os.pathsep.join([*libraries, str(Path(python).parents[1] / "lib")]),
        "_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1",
        "AMENT_PREFIX_PATH": str(Path(python).parents[1]),
    }


@pytest.mark.slow
def test_orders_parameters_and_life_cycle(rclpy_python: str, domain: dict[str, str], tmp_path: Path) -> None:
    environment = {**domain, **sourced(rclpy_python)}
    words = [sys.executable, "-m", "skylimb", "ros2", "both", "--controller", "hybrid"]
    log = tmp_path / "node.log"
    with log.open("wb") as out:
        node = subprocess.Popen(words, env=environment, stdout=out, stderr=subprocess.STDOUT)
        own = {name: value for name, value in domain.items() if name != "PYTHONPATH"}
        client = [rclpy_python, str(CLIENT), "/skylimb/skylimb_both", str(tmp_path / "said.json")]
        asked = subprocess.run(client, env=own, capture_output=True, text=True, timeout=300, check=False)
        if asked.returncode:
            node.kill()
        node.wait(120)  # its life cycle has ended: it lands by itself
    assert asked.returncode == 0, asked.stdout + asked.stderr + log.read_text(encoding="utf-8")
    said = json.loads((tmp_path / "said.json").read_text(encoding="utf-8"))
    assert said["early"] == [False, "takeoff is refused in ARM_OFF: start comes first"]
    assert said["start"] == [True, "START"]
    assert said["takeoff"] == [True, "TAKEOFF"]
    assert said["state"] == "active"
    assert {"plant.mass_scale", "surface.friction", "phases.hover"} <= set(said["names"])
    assert said["value"] == 1.0
    assert said["range"] == [[0.5, 2.0]]
    assert said["described"] == "true over described mass and inertia, all links (0.5 .. 2)"
    assert said["set"][0] is False
    assert "read-only" in said["set"][1]
    assert said["left"] is True
    text = log.read_text(encoding="utf-8")
    assert "-> LAND\n" in text
    assert "Traceback" not in text
