"""From a controller's command to the plant's controls."""

from __future__ import annotations

from skylimb.control.records import Command
from skylimb.robots.description import RobotDescription
from skylimb.symbolic import Array, clip, stack


def actuate(description: RobotDescription, command: Command, activations: Array, dt: float) -> Array:
    """Controls in the plant's order: thrusts (N), then set-point rates of shape and vectoring servos (rad/s).

    Args:
        description: limits; the rotors' lag is in the plant.
        command: of this tick.
        activations: the plant's activations now: thrusts, then servo set points.
        dt: control period, s; a set point reaches its command at the end of it if the speed limit allows.
    """
    n, nq = len(description.rotors), len(description.shape_joints)
    shape_rate = (command.joint_angles - activations[n : n + nq]) * (1.0 / dt)
    vectoring_rate = (command.vectoring_angles - activations[n + nq :]) * (1.0 / dt)
    shape_limit = description.shape_servos.speed_limit
    vectoring_limit = description.vectoring_servos.speed_limit
    return stack(
        command.thrusts,
        clip(shape_rate, -shape_limit, shape_limit),
        clip(vectoring_rate, -vectoring_limit, vectoring_limit),
    )
