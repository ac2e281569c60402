"""What the loop flies: anything that can be measured and commanded once a tick."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from skylimb.base.packing import Layout
from skylimb.control.estimation.records import Measurement, zero_measurement
from skylimb.control.records import Command
from skylimb.robots.model import Robot

MEASURED = (
    "root_position_measured",
    "root_quaternion_measured",
    "root_velocity_measured",
    "root_angular_velocity_measured",
    "joint_angles_measured",
    "vectoring_angles_measured",
    "capture_age",
    "imu_angular_velocity_measured",
    "imu_specific_force_measured",
)
"""Signals of a measurement, in the order of its entries."""


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


def measured_signals(measurement: Measurement) -> dict[str, Any]:
    """The signals of a measurement by name; those of an IMU only where there is one."""
    return dict(zip(MEASURED, measurement.entries, strict=False))


def nothing_measured(robot: Robot, imu: bool = False) -> Measurement:
    """A measurement that nobody believes: no number is one."""
    sizes = Layout(zero_measurement(robot.n_joints, robot.n_vectoring, imu))
    return sizes.unpack(np.full(sizes.size, np.nan))


def measured_layout(robot: Robot, imu: bool = False) -> Layout[dict[str, Any]]:
    """Layout of what is known of a robot that is no simulation: measurement and command.

    Args:
        robot: what flies.
        imu: whether the measurements have an IMU's.
    """
    return Layout(
        {
            **measured_signals(zero_measurement(robot.n_joints, robot.n_vectoring, imu)),
            "thrusts_command": np.zeros(robot.n_rotors),
            "joint_angles_command": np.zeros(robot.n_joints),
            "vectoring_angles_command": np.zeros(robot.n_vectoring),
        }
    )
