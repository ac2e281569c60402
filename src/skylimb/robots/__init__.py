"""Robots: description files -> kinematics, mass properties, hovering frame and allocation matrix.

What it is for: all that is known of a robot at rest. A URDF and a flight TOML become a `Robot`, whose
functions take numbers and CasADi symbols alike; and one question, whether it can be held, is asked of any
posture and push.

Where to start reading: `loader` (from a name or a path to a checked robot), `description` and `links` (what
its files say), `model` (what follows from its angles), `hovering` (the frame {C} and the allocation matrix),
`equilibrium` (can it be held, how hard can it push), `reaction` (what rotors with an inertia do to lift and
torque).

It may import `base` alone: no controller, no engine, no record.
"""

from skylimb.robots.description import GRAVITY, PostureFamily, RobotDescription, Rotor, Servo, Tip
from skylimb.robots.links import Inertial, Joint, Link, Visual
from skylimb.robots.loader import SHIPPED, list_robots, load_robot, read_description
from skylimb.robots.model import Robot
from skylimb.robots.posed import RobotState

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
