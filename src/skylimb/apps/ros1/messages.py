"""What passes between the lab's topics and us, as plain values: no middleware has a part in it.

SI units; quaternions w x y z; stamps in seconds on the clock of whoever set them. A middleware is one folder
like `ros1.rim`, which turns its own messages into these and back.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

from skylimb.robots.description import GRAVITY

Vector = tuple[float, float, float]
Turn = tuple[float, float, float, float]

WORLD = "world"


@dataclass(frozen=True)
class Pose:
    """A stamped pose in W: of the flight controller (`mocap/pose`), or a target (`target_pose`)."""

    stamp: float
    position: Vector
    quaternion: Turn


@dataclass(frozen=True)
class Path:
    """Poses to fly through, one after another (`target_path`)."""

    poses: tuple[Pose, ...]


@dataclass(frozen=True)
class Imu:
    """Attitude and rates of the flight controller, its own axes."""

    stamp: float
    quaternion: Turn
    gyro: Vector
    acceleration: Vector = (0.0, 0.0, GRAVITY)


@dataclass(frozen=True)
class Joints:
    """Angles by name, rad: measured (`joint_states`), or wanted (`joints_ctrl`, `gimbals_ctrl`)."""

    stamp: float
    names: tuple[str, ...]
    angles: tuple[float, ...]


@dataclass(frozen=True)
class FourAxes:
    """What the flight controller is to do (`four_axes/command`).

    Attributes:
        angles: roll and pitch targets, rad, and the yaw term, N.
        base_thrust: N, in the order of the rotors.
    """

    angles: Vector
    base_thrust: tuple[float, ...]


@dataclass(frozen=True)
class Gains:
    """Attitude gains of each rotor, in thousandths (`rpy/gain`).

    Attributes:
        motors: roll p i d, pitch p i d, yaw d, each 16 bits.
    """

    motors: tuple[tuple[int, ...], ...]


@dataclass(frozen=True)
class ServoAngles:
    """Servos by their number on the bus, in counts (`servo/states`, `servo/target_states`).

    Attributes:
        stamp: of the measurement; a target has none.
        counts: by number.
    """

    stamp: float
    counts: dict[int, int]


@dataclass(frozen=True)
class Motor:
    """How thrust hangs on duty at a voltage.

    Attributes:
        voltage: V.
        max_thrust: N.
        polynomial: of the lab's table, from degree 0 up.
    """

    voltage: float
    max_thrust: float
    polynomial: tuple[float, float, float, float, float]


@dataclass(frozen=True)
class MotorInfo:
    """Motors, as the flight controller has to know them before it arms (`motor_info`).

    Attributes:
        min_pwm: duty, 0 .. 1.
        max_pwm: duty, 0 .. 1.
        min_thrust: N.
        force_landing_thrust: mean thrust that a forced landing ends at, N.
        conversion: 0 by a square root, 1 by a polynomial.
        motors: at some voltages.
    """

    min_pwm: float
    max_pwm: float
    min_thrust: float
    force_landing_thrust: float
    conversion: int
    motors: tuple[Motor, ...]


@dataclass(frozen=True)
class UavInfo:
    """How many motors it has, and the lab's number of its kind (`uav_info`)."""

    motors: int
    model: int


@dataclass(frozen=True)
class PMatrix:
    """For the gyro term, in thousandths (`p_matrix_pseudo_inverse_inertia`).

    Attributes:
        rows: of each rotor: roll, pitch, yaw.
        inertia: xx yy zz xy yz xz.
    """

    rows: tuple[tuple[int, int, int], ...]
    inertia: tuple[int, ...]


@dataclass(frozen=True)
class Desire:
    """Axes that are controlled, seen from the board (`desire_coordinate`), rad."""

    roll: float
    pitch: float
    yaw: float


class NavMode(IntEnum):
    """How an axis of `uav/nav` is meant."""

    NO = 0
    VELOCITY = 1
    POSITION = 2
    ACCELERATION = 3
    POSITION_VELOCITY = 4
    GPS = 5


@dataclass(frozen=True)
class Nav:
    """A user's step or velocity (`uav/nav`); fields that the lab's stack does not use are left out.

    Attributes:
        xy_mode: of x and y.
        z_mode: of z.
        yaw_mode: of yaw.
        position: target, W, m.
        velocity: target, m/s.
        yaw: target, rad.
        yaw_rate: target, rad/s.
        local: whether velocities are in the robot's own axes.
    """

    xy_mode: int
    z_mode: int
    yaw_mode: int
    position: Vector
    velocity: Vector
    yaw: float = 0.0
    yaw_rate: float = 0.0
    local: bool = False


@dataclass(frozen=True)
class Odometry:
    """Pose in W of a frame; linear velocity in W, angular velocity in the frame."""

    stamp: float
    frame: str
    position: Vector
    quaternion: Turn
    velocity: Vector
    angular_velocity: Vector


@dataclass(frozen=True)
class Transform:
    """Pose of a frame in another one (`/tf`)."""

    stamp: float
    parent: str
    child: str
    position: Vector
    quaternion: Turn


@dataclass(frozen=True)
class Transforms:
    """Frames that are told together (`/tf`)."""

    frames: tuple[Transform, ...]


@dataclass(frozen=True)
class Axis:
    """Target and error of an axis (`debug/pose/pid`)."""

    target: float
    error: float
    target_rate: float = 0.0
    rate_error: float = 0.0


@dataclass(frozen=True)
class PoseControl:
    """Targets and errors of x, y, z, roll, pitch and yaw (`debug/pose/pid`)."""

    stamp: float
    axes: tuple[Axis, Axis, Axis, Axis, Axis, Axis]


@dataclass(frozen=True)
class Wrench:
    """External force in W and torque about the centre of gravity, as estimated."""

    stamp: float
    force: Vector
    torque: Vector


@dataclass(frozen=True)
class Diagnosis:
    """What is wrong, for `/diagnostics`.

    Attributes:
        level: 0 for well, 1 for a warning, 2 for an error.
        words: one line.
        values: counts and states, by name.
    """

    level: int
    words: str
    values: dict[str, str] = field(default_factory=dict)
