"""DDS on a domain of the test's own; a Python with rclpy judges, where there is one."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
if importlib.util.find_spec("cyclonedds") is None:  # no wheel for this Python
    collect_ignore_glob = ["test_[!i]*.py"]  # all but what says so
WHEELS = (
    "ros-rclpy ros-rmw-fastrtps-cpp ros-geometry-msgs ros-sensor-msgs ros-nav-msgs ros-std-srvs "
    "ros-diagnostic-msgs numpy"
)


@pytest.fixture(scope="session")
def rclpy_python() -> str:
    """A Python with rclpy: SKYLIMB_RCLPY, else out/rclpy/bin/python, else this one."""
    for python in (os.environ.get("SKYLIMB_RCLPY", ""), str(ROOT / "out/rclpy/bin/python"), sys.executable):
        if python and Path(python).exists():
            tried = subprocess.run([python, "-c", "import rclpy"], capture_output=True, check=False)
            if tried.returncode == 0:
                return python
    pytest.skip(f"no rclpy: python -m venv out/rclpy && out/rclpy/bin/pip install {WHEELS}")


@pytest.fixture
def domain(monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """Environment of a domain that no other test has at the same time."""
    number = str(100 + os.getpid() % 100)
    monkeypatch.setenv("ROS_DOMAIN_ID", number)
    found = {**os.environ, "ROS_DOMAIN_ID": number, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    return {**found, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
