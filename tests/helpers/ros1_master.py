"""A ROS master as a process."""

from __future__ import annotations

import socket
import subprocess
import time


def started_master(environment: dict[str, str]) -> subprocess.Popen[bytes]:
    """A master that answers at the environment's port."""
    port = environment["MASTER_PORT"]
    # Debian's program is for Debian's own Python.
    own = {name: value for name, value in environment.items() if name != "PYTHONPATH"}
    process = subprocess.Popen(
        ["rosmaster", "--core", "-p", port],
        env=own,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    for _ in range(200):
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", int(port))) == 0:
                break
        time.sleep(0.05)
    return process
