"""The records that measurements and estimates travel in.

Leaves are NumPy arrays in a test and CasADi symbols in the compiled tick. W is the world frame, C the
hovering frame at the centre of gravity, B the measured body's own frame.
"""

from __future__ import annotations

from typing import NamedTuple

from skylimb.robots.model import RobotState
from skylimb.symbolic import Array


class Measurement(NamedTuple):
    """What the sensors say at a control tick.

    Attributes:
        position: origin of the measured body in W, m, (3,).
        quaternion: attitude of the measured body, (w, x, y, z).
        velocity: of that origin in W, m/s, (3,).
        angular_velocity: of the body, in B, rad/s, (3,).
        joint_angles: shape joints q, rad.
        vectoring_angles: vectoring joints psi, rad.
    """

    position: Array
    quaternion: Array
    velocity: Array
    angular_velocity: Array
    joint_angles: Array
    vectoring_angles: Array


class BodyState(NamedTuple):
    """The rigid-body state of the whole robot, seen at {C}.

    Attributes:
        position: centre of gravity in W, m, (3,).
        velocity: of the centre of gravity in W, m/s, (3,).
        R_WC: rotation of C seen from W, (3, 3).
        angular_velocity: of C in C, rad/s, (3,).
        model: mass, inertia, allocation and tip at the measured joint and vectoring angles.
    """

    position: Array
    velocity: Array
    R_WC: Array
    angular_velocity: Array
    model: RobotState


class Wrench(NamedTuple):
    """A wrench on the robot at its centre of gravity: force in W (N), torque in C (N m)."""

    force: Array
    torque: Array
