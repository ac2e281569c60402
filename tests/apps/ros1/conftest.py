"""A ROS master of our own, where ROS is; without ROS these tests are skipped."""

from __future__ import annotations

import os
import shutil
import socket
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from ros1_master import started_master
from skylimb.analysis.exchange.message_types import Definitions
from skylimb.apps.ros1.installation import require_ros
from skylimb.base.errors import MissingExtraError

MESSAGES = Path(__file__).parents[2] / "analysis" / "exchange" / "messages"


@pytest.fixture(scope="session")
def ros() -> None:
    """ROS's Python packages."""
    try:
        require_ros()
    except MissingExtraError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="session")
def definitions() -> Definitions:
    return Definitions([MESSAGES])


@pytest.fixture
def master(ros: None, tmp_path: Path) -> Iterator[dict[str, str]]:
    """Environment of a master on a free port, which ends with the test."""
    if shutil.which("rosmaster") is None:
        pytest.skip("no rosmaster here: apt-get install python3-rosmaster")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    environment = {
        "MASTER_PORT": str(port),
        **os.environ,
        "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
        "ROS_IP": "127.0.0.1",
        "ROS_HOME": str(tmp_path / "ros_home"),
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
    }
    process = started_master(environment)
    environment["MASTER_PID"] = str(process.pid)
    yield environment
    process.terminate()
    process.wait(10)
