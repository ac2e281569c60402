"""A user's controller in Python that holds its thrusts and fails after some ticks."""

import os
from pathlib import Path

CONTROLLER = """
import numpy as np
from skylimb.control.records import Command


class Still:
    name = "still"

    def __init__(self, robot):
        self.command = Command(
            np.full(robot.n_rotors, 8.0), np.zeros(robot.n_joints), np.zeros(robot.n_vectoring)
        )

    def gains(self):
        return None

    def initial_state(self):
        return 0

    def step(self, gains, state, measurement, reference, dt):
        float(np.asarray(measurement.position)[0])  # flies in Python
        state = state + 1
        if state > LIMIT:
            raise ZeroDivisionError("too late")
        return state, self.command, {"count": state}


def controller(robot):
    return Still(robot)
"""


def save_failing_controller(path: Path, limit: int) -> None:
    """Write the controller, which fails after `limit` ticks, as a later edit than the last one."""
    before = path.stat().st_mtime_ns if path.exists() else 0
    path.write_text(CONTROLLER.replace("LIMIT", str(limit)))
    os.utime(path, ns=(before + 10**9, before + 10**9))
