"""The records that measurements and estimates travel in.

Leaves are NumPy arrays in a test and CasADi symbols in the compiled tick. W is the world frame, C the
hovering frame at the centre of gravity, B the measured body's own frame.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from skylimb.control.missions.reference import Reference
from skylimb.robots.model import Robot
from skylimb.robots.posed import RobotState
from skylimb.symbolic import Array

Signals = dict[str, Any]
"""What a law records at a tick, by its public name."""


ABSENT: Any = None
"""In the place of a field of a record that a law does not fill in."""


class Imu(NamedTuple):
    """What an IMU says of the link that it sits on, in its own axes; the joints' motion is in it.

    Attributes:
        angular_velocity: of the link, rad/s, (3,).
        specific_force: acceleration of the IMU's origin without gravity's share, mean since the last tick,
            m/s^2, (3,); at rest g along up.
    """

    angular_velocity: Array
    specific_force: Array


class Measurement(NamedTuple):
    """What the sensors measure at a control tick.

    Attributes:
        position: origin of the measured body in W, m, (3,).
        quaternion: attitude of the measured body, (w, x, y, z).
        velocity: of that origin in W, m/s, (3,).
        angular_velocity: of the body, in B, rad/s, (3,).
        joint_angles: shape joints q, rad, (n_joints,).
        vectoring_angles: vectoring joints psi, rad, (n_vectoring,).
        capture_age: of the motion capture's frame that is seen now, in pose and twist, as its stamp says, s.
        imu: absent where the robot has none, or nobody needs it.
    """

    position: Array
    quaternion: Array
    velocity: Array
    angular_velocity: Array
    joint_angles: Array
    vectoring_angles: Array
    capture_age: Any = 0.0
    imu: Imu | None = ABSENT

    @property
    def entries(self) -> tuple[Any, ...]:
        """Every entry in turn, those of an IMU behind the others: what travels flat."""
        return (*self[:-1], *(self.imu or ()))


class Taken(NamedTuple):
    """When the parts of a measurement were measured, s; they come from sensors of their own.

    Attributes:
        pose: pose and twist; not finite while none has come.
        joints: joint and vectoring angles; likewise.
    """

    pose: float = -np.inf
    joints: float = -np.inf


def zero_measurement(n_joints: int, n_vectoring: int, imu: bool = False) -> Measurement:
    """A measurement of zeros, which shows the sizes of all entries."""
    z3 = np.zeros(3)
    angles = np.zeros(n_joints), np.zeros(n_vectoring)
    return Measurement(z3, np.zeros(4), z3, z3, *angles, 0.0, Imu(z3, z3) if imu else ABSENT)


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


class Sensed(NamedTuple):
    """What an estimation law works on.

    Attributes:
        robot: the controller's model of the robot.
        measurement: of this tick.
        reference: of this tick; it names the contact axis and the ticks of the tare.
        dt: control period, s.
    """

    robot: Robot
    measurement: Measurement
    reference: Reference
    dt: float


class Estimate(NamedTuple):
    """What an estimation law knows at a tick; what it does not know is absent, except for the body.

    Attributes:
        body: state of {C} and the model at the measured angles.
        wrench: external wrench, its bias in free flight taken off.
        raw: external wrench with that bias.
        contact_force: filtered force along the contact axis, N, negative when the robot is pushed back.
        arm: from the centre of gravity to the tip in W, m, (3,).
        bias: wrench that the rotors have to make up in free flight.
        scale: of all thrusts, given over commanded.
    """

    body: BodyState
    wrench: Wrench = ABSENT
    raw: Wrench = ABSENT
    contact_force: Any = ABSENT
    arm: Array = ABSENT
    bias: Wrench = ABSENT
    scale: Any = ABSENT


class Start(NamedTuple):
    """What every law knows before the first tick.

    Attributes:
        robot: the controller's model of the robot.
        reach: of the nominal posture, m.
        hover_thrusts: of the nominal posture, N, (n,).
    """

    robot: Robot
    reach: float
    hover_thrusts: np.ndarray
