"""What passes between a controller and a robot, whatever carries it: two plain messages.

A middleware is one file that turns its own messages into these and back. Over a socket they travel as
msgpack maps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar

import msgspec
import numpy as np

from skylimb.control.estimation.records import ABSENT, Imu, Measurement
from skylimb.control.records import Command
from skylimb.robots.model import Robot

T = TypeVar("T")

GREETING = b"\x80"
"""An empty map: it commands nothing, and says where one listens."""

LONGEST = 4096
"""Bytes of a message at most; a longer one is none of ours."""


@dataclass(frozen=True)
class StateMessage:
    """What a robot measures. SI units; quaternion w x y z.

    Attributes:
        seq: rises with every message.
        stamp: when it was measured, s on the robot's own clock.
        position: of the measured link in W.
        quaternion: its attitude.
        velocity: of its origin in W.
        angular_velocity: in its own axes.
        names: of joints and vectoring joints, in any order.
        angles: of each.
        capture_age: of pose and twist when they were sent, s.
        imu_angular_velocity: of the IMU's link, in the IMU's axes, rad/s; nothing where there is no IMU.
        imu_specific_force: acceleration there without gravity's share, mean since the last message, m/s^2.
        battery: charge, per cent; nothing where nobody knows.
        mass: of the robot as it knows itself, kg.
        loop_delay: from the measurement that the newest command answers until that command came, s on the
            robot's clock; nothing before one came, and where nobody knows.
    """

    seq: int
    stamp: float
    position: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]
    velocity: tuple[float, float, float]
    angular_velocity: tuple[float, float, float]
    names: tuple[str, ...]
    angles: tuple[float, ...]
    capture_age: float = 0.0
    imu_angular_velocity: tuple[float, float, float] | None = None
    imu_specific_force: tuple[float, float, float] | None = None
    battery: float | None = None
    mass: float | None = None
    loop_delay: float | None = None


@dataclass(frozen=True)
class CommandMessage:
    """What a robot is to do.

    Attributes:
        seq: rises with every message.
        stamp: of the measurement that it answers, s on the robot's clock.
        thrusts: N, in the order of the rotors.
        names: of joints and vectoring joints.
        angles: of each, rad.
    """

    seq: int
    stamp: float
    thrusts: tuple[float, ...]
    names: tuple[str, ...]
    angles: tuple[float, ...]


class RefusedMessageError(ValueError):
    """A message that is none: its text is the fault's name."""


def encode(message: StateMessage | CommandMessage) -> bytes:
    """The message as a msgpack map."""
    return msgspec.msgpack.encode(message)


def decode(data: bytes, kind: type[T]) -> T:
    """The message of a kind (`StateMessage`, `CommandMessage`) in a datagram.

    Raises:
        RefusedMessageError: when there is none.
    """
    if len(data) > LONGEST:
        raise RefusedMessageError("message too long")
    try:
        return msgspec.msgpack.decode(data, type=kind)
    # Strings that are no UTF-8 and numbers that no double holds have errors of their own.
    except (msgspec.MsgspecError, ValueError, OverflowError, RecursionError):
        raise RefusedMessageError("no message of ours") from None


class Names:
    """Which joints a robot has, and how its messages are read and written.

    Args:
        robot: whose.
    """

    def __init__(self, robot: Robot) -> None:
        description = robot.description
        self.joints, self.vectoring = description.shape_joints, description.vectoring_joints
        self._all = (*self.joints, *self.vectoring)
        self._rotors = len(description.rotors)

    def measurement(self, message: StateMessage) -> Measurement:
        """The measurement in a state, its joints put in the robot's order by name.

        Raises:
            RefusedMessageError: when names are missing, doubled or unknown.
        """
        angles = self._in_order(message.names, message.angles)
        if not math.isfinite(message.stamp + message.capture_age):
            raise RefusedMessageError("stamp is no number")
        count = len(self.joints)
        parts = (message.position, message.quaternion, message.velocity, message.angular_velocity)
        p, q, v, w = (np.array(part, dtype=float) for part in parts)
        felt = message.imu_angular_velocity, message.imu_specific_force
        imu = ABSENT if None in felt else Imu(*(np.array(part, dtype=float) for part in felt))
        return Measurement(p, q, v, w, angles[:count], angles[count:], message.capture_age, imu)

    def command(self, message: CommandMessage) -> Command:
        """The command in a message; see `measurement`. It has a finite number for each actuator."""
        if len(message.thrusts) != self._rotors:
            raise RefusedMessageError("wrong size")
        if not all(map(math.isfinite, (*message.thrusts, *message.angles))):
            raise RefusedMessageError("command is no number")
        angles, count = self._in_order(message.names, message.angles), len(self.joints)
        return Command(np.array(message.thrusts, dtype=float), angles[:count], angles[count:])

    def _in_order(self, names: tuple[str, ...], angles: tuple[float, ...]) -> np.ndarray:
        if len(names) != len(angles):
            raise RefusedMessageError("wrong size")
        known = dict(zip(names, angles, strict=True))
        if len(known) != len(names) or known.keys() != set(self._all):
            raise RefusedMessageError("wrong joint names")
        return np.array([known[name] for name in self._all], dtype=float)

    def state_message(self, seq: int, stamp: float, measurement: Measurement) -> StateMessage:
        """A measurement as a message."""
        p, q, v, w, joints, vectoring, *felt = (
            tuple(map(float, part)) for part in (*measurement[:6], *(measurement.imu or ()))
        )
        age, angles = float(measurement.capture_age), (*joints, *vectoring)
        return StateMessage(seq, stamp, p, q, v, w, self._all, angles, age, *felt)  # type: ignore[arg-type]

    def command_message(self, seq: int, stamp: float, command: Command) -> CommandMessage:
        """A command as a message."""
        thrusts, joints, vectoring = (tuple(map(float, part)) for part in command)
        return CommandMessage(seq, stamp, thrusts, self._all, (*joints, *vectoring))
