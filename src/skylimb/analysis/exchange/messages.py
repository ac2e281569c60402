"""What the lab's messages say, as plain values: no middleware has a part in it.

SI units; quaternions w x y z; stamps in seconds on the clock of whoever set them. `codec` turns ROS messages
into these and back. What is only published, and read by nobody here, has no class: `lab_messages` gives its
fields by name.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

WORLD = "world"
"""The frame of poses and targets."""

IDLE = 1040
"""Duty of a motor that stands at most, of 2000: the flight controller's is 1000."""


@dataclass(frozen=True)
class Pose:
    """A stamped pose in W: of the flight controller (`mocap/pose`), or a target (`target_pose`)."""

    stamp: float
    position: Vector
    quaternion: Quaternion
    frame: str = WORLD


@dataclass(frozen=True)
class Path:
    """Poses to fly through, one after another (`target_path`)."""

    poses: tuple[Pose, ...]
    frame: str = WORLD


@dataclass(frozen=True)
class Imu:
    """Rates and attitude of the flight controller, in its own axes.

    Attributes:
        stamp: s.
        gyro: rad/s.
        acceleration: without gravity's share: upward at rest, m/s^2.
        quaternion_xyzw: attitude, in the order x y z w of the message.
        magnetic_field: of the compass.
    """

    stamp: float
    gyro: Vector
    acceleration: Vector = (0.0, 0.0, 0.0)
    quaternion_xyzw: Quaternion = (0.0, 0.0, 0.0, 1.0)
    magnetic_field: Vector = (0.0, 0.0, 0.0)

    @property
    def tells(self) -> bool:
        """Whether its rates are numbers; without them it counts as silent."""
        return all(map(math.isfinite, self.gyro))


@dataclass(frozen=True)
class Joints:
    """Angles by name, rad: measured (`joint_states`), or commanded (`joints_ctrl`, `gimbals_ctrl`)."""

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
        motors: roll p i d, pitch p i d, yaw d, each 16 bits; a single entry is gains of torques.
    """

    motors: tuple[tuple[int, ...], ...]


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
class TorqueInverse:
    """Thrusts for a torque of one, in thousandths (`torque_allocation_matrix_inv`).

    Attributes:
        rows: of each rotor: x, y, z.
    """

    rows: tuple[tuple[int, int, int], ...]


@dataclass(frozen=True)
class Desire:
    """Axes that are controlled, seen from the board (`desire_coordinate`), rad."""

    roll: float
    pitch: float
    yaw: float


@dataclass(frozen=True)
class ServoStates:
    """Measured servos (`servo/states`): number on the bus and count of each."""

    stamp: float
    counts: tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class ServoTargets:
    """Commanded servos (`servo/target_states`): numbers on the bus, one byte each, and their counts.

    Raises:
        ValueError: for a target without number, or a number without target.
    """

    numbers: bytes
    counts: tuple[int, ...]

    def __post_init__(self) -> None:
        if len(self.numbers) != len(self.counts):
            raise ValueError(f"{len(self.counts)} targets for {len(self.numbers)} servos")


@dataclass(frozen=True)
class ServoTorques:
    """Servos whose torque is switched (`servo/torque_enable`): numbers on the bus, and 0 or 1 for each.

    Raises:
        ValueError: for another number of switches than of servos.
    """

    numbers: bytes
    on: bytes

    def __post_init__(self) -> None:
        if len(self.numbers) != len(self.on):
            raise ValueError(f"{len(self.on)} switches for {len(self.numbers)} servos")


@dataclass(frozen=True)
class Motor:
    """How thrust depends on duty at a voltage.

    Attributes:
        voltage: V.
        max_thrust: N.
        polynomial: of the lab's table, from degree 0 up, (5,).
    """

    voltage: float
    max_thrust: float
    polynomial: tuple[float, ...]


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

    def duties(self, thrusts: Iterable[float], volts: float) -> tuple[float, ...]:
        """Duties for some thrusts, N, with a battery of so many volts, as the flight controller has them."""
        motor = min(self.motors, key=lambda one: abs(one.voltage - volts))
        sag = (motor.voltage / volts) ** (1.5 if self.conversion else 2.0)

        def duty(thrust: float) -> float:
            force, c = max(sag * thrust, 0.0), motor.polynomial
            if self.conversion:
                return sum(part * (0.1 * force) ** degree for degree, part in enumerate(c)) / 100.0
            return (-c[1] + max(c[1] ** 2 - 40.0 * c[2] * (c[0] - force), 0.0) ** 0.5) / (200.0 * c[2])

        least = duty(self.min_thrust) if self.min_thrust > 0.0 else self.min_pwm
        return tuple(min(max(duty(one), least), self.max_pwm) for one in thrusts)

    def most(self, duties: Iterable[int], volts: float | None) -> float:
        """What duties, 0 .. 2000, give together at most, N; infinity where that cannot be said.

        Args:
            duties: of each motor.
            volts: of the battery; None where nobody knows, which counts as a full one.
        """
        if not self.motors:
            return math.inf
        volts = volts or max(one.voltage for one in self.motors)
        top = max(one.max_thrust for one in self.motors)
        thrusts = [top * part / 330.0 for part in range(331)]

        def known(thrust: float) -> float:
            return 2000.0 * self.duties((thrust,), volts)[0]

        # The board cuts what is behind the point; a duty beyond them all may be any thrust.
        return sum([*thrusts, math.inf][bisect_left(thrusts, duty + 1, key=known)] for duty in duties)


@dataclass(frozen=True)
class Pwms:
    """What the motors are driven with (`motor_pwms`), and so whether they turn.

    Attributes:
        stamp: s.
        duties: of each, 0 .. 2000.
    """

    stamp: float
    duties: tuple[int, ...]

    @property
    def armed(self) -> bool:
        """Whether any of them is driven with more than a motor that stands."""
        return max(self.duties, default=0) > IDLE


@dataclass(frozen=True)
class UavInfo:
    """How many motors it has, and the lab's number of its kind (`uav_info`)."""

    motors: int
    model: int


@dataclass(frozen=True)
class Joy:
    """A radio's sticks, -1 .. 1, and its buttons, 0 or 1 (`joy`)."""

    stamp: float
    axes: tuple[float, ...]
    buttons: tuple[int, ...]


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
        xy_mode: of x and y, a `NavMode`.
        z_mode: of z.
        yaw_mode: of yaw.
        position: target, W, m.
        velocity: target, m/s.
        yaw: target, rad.
        yaw_rate: target, rad/s.
        frame: of the velocities: 0 for W, 1 for the robot's own axes.
    """

    xy_mode: int
    z_mode: int
    yaw_mode: int
    position: Vector
    velocity: Vector
    yaw: float = 0.0
    yaw_rate: float = 0.0
    frame: int = 0
