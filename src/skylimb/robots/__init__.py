"""Robots: description files -> kinematics, mass properties, hovering frame and allocation matrix."""

from skylimb.robots.description import (
    GRAVITY,
    Inertial,
    Joint,
    Link,
    PostureFamily,
    RobotDescription,
    Rotor,
    Servo,
    Tip,
    Visual,
)
from skylimb.robots.loader import SHIPPED, list_robots, load_robot, read_description
from skylimb.robots.model import Robot, RobotState

__all__ = [
    "GRAVITY",
    "SHIPPED",
    "Inertial",
    "Joint",
    "Link",
    "PostureFamily",
    "Robot",
    "RobotDescription",
    "RobotState",
    "Rotor",
    "Servo",
    "Tip",
    "Visual",
    "list_robots",
    "load_robot",
    "read_description",
]
