"""What the loop flies: anything that can be measured and commanded once a tick."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from skylimb.base.packing import Layout
from skylimb.control.estimation.records import Measurement
from skylimb.control.records import Command
from skylimb.robots.model import Robot


class Vehicle(Protocol):
    """A simulated plant, the same in real time, a recorded log, or a robot behind a network.

    The loop calls, in every tick and in this order, `measure`, `record` and `apply`.
    """

    @property
    def layout(self) -> Layout[dict[str, Any]]:
        """Where each signal stands in what `record` returns."""
        ...

    def measure(self) -> Measurement:
        """What the sensors say now."""
        ...

    def record(self, measurement: Measurement, command: Command) -> np.ndarray:
        """The tick's signals besides the controller's own: measurement, command, and truth where it is known.

        Args:
            measurement: of this tick.
            command: that is about to be applied.

        Returns:
            Flat, in the order of `layout`.
        """
        ...

    def apply(self, command: Command) -> None:
        """Pass the command on; returns when the next tick is due."""

    def fault(self) -> str:
        """Why the vehicle's state can no longer be trusted; empty while it can."""
        ...


def measured_layout(robot: Robot) -> Layout[dict[str, Any]]:
    """Layout of what is known of a robot that is no simulation: measurement and command."""
    q, psi = np.zeros(robot.n_joints), np.zeros(robot.n_vectoring)
    return Layout(
        {
            "root_position_measured": np.zeros(3),
            "root_quaternion_measured": np.zeros(4),
            "root_velocity_measured": np.zeros(3),
            "root_angular_velocity_measured": np.zeros(3),
            "joint_angles_measured": q,
            "vectoring_angles_measured": psi,
            "thrusts_command": np.zeros(robot.n_rotors),
            "joint_angles_command": q,
            "vectoring_angles_command": psi,
        }
    )
