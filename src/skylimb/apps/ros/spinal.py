"""What the lab's flight controller remembers, and what each message of the computer's makes of it.

Numbers of messages are thousandths, as they travel. What it does with them: `attitude_loop`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from skylimb.analysis.exchange.messages import (
    Desire,
    FourAxes,
    Gains,
    MotorInfo,
    PMatrix,
    Pwms,
    TorqueInverse,
    UavInfo,
)
from skylimb.apps.ros.states import Arming
from skylimb.base.rotations import rotation_from_rpy

TILT = 1.0
"""Roll or pitch, measured or commanded, beyond which it lands by force, rad."""

LEAST = 7.0
"""Mean base thrust that a forced landing ends at where nobody says, N."""

MOST_COMPONENTS = 10
"""Of the rotors' forces, for which the board has room."""

Told = FourAxes | Gains | PMatrix | TorqueInverse | Desire | UavInfo | MotorInfo

_MILLI = 1e-3
_INTEGRATE = {160: True, 161: False}


class Spinal(NamedTuple):
    """All that it remembers.

    Attributes:
        rotors: how many.
        gimbal_dof: in how many directions the board turns each rotor itself, 0 to 2; a base thrust, a row of
            gains and the like then stand for each component of a rotor's force, x (y) z.
        uav: the computer's `uav_info`; None before it came.
        motors: likewise its `motor_info`.
        armed: whether the motors turn.
        force_landing: whether it lands by force.
        integrates: whether errors are integrated.
        heard: when the last command came, s; None before the first one.
        base: thrusts, N, (n,); nothing before the first command.
        angles: roll and pitch targets, rad, (2,).
        yaw: the computer's yaw term of each rotor, N, (n,); shared out by the gains of when it came.
        gains: of each rotor: p, i, d by roll, pitch, yaw, (3, n, 3).
        torque_gains: p, i, d by roll, pitch, yaw, where a message gives them once for all rotors, (3, 3).
        torque_inverse: thrusts for a torque, by which those become gains of each rotor, (n, 3).
        p_matrix: pseudo-inverse for the gyro term, (n, 3).
        inertia: (3, 3).
        offset: from the board's axes to those that are controlled, (3, 3).
        integral: of the errors of roll and pitch, rad s, (2,).
        terms: what they came to at the last pass, in the order of the gains, N, (3, n, 3).
        thrusts: what was asked for then, N, (n,).
        gimbals: angles of the rotors that the board turns, (n * gimbal_dof,) rad.
    """

    rotors: int
    gimbal_dof: int = 0
    uav: UavInfo | None = None
    motors: MotorInfo | None = None
    armed: bool = False
    force_landing: bool = False
    integrates: bool = False
    heard: float | None = None
    base: np.ndarray = np.zeros(0)
    angles: tuple[float, float] = (0.0, 0.0)
    yaw: np.ndarray = np.zeros(0)
    gains: np.ndarray | None = None
    torque_gains: np.ndarray | None = None
    torque_inverse: np.ndarray | None = None
    p_matrix: np.ndarray | None = None
    inertia: np.ndarray | None = None
    offset: np.ndarray | None = None
    integral: tuple[float, float] = (0.0, 0.0)
    terms: np.ndarray | None = None
    thrusts: np.ndarray | None = None
    gimbals: np.ndarray = np.zeros(0)

    @property
    def entries(self) -> int:
        """Components of the rotors' forces."""
        return self.rotors * (self.gimbal_dof + 1)

    @property
    def ready(self) -> bool:
        """Whether it may be armed: it knows how many motors it has, and their range of duty."""
        motors = self.motors
        return self.uav is not None and motors is not None and motors.max_pwm > motors.min_pwm

    @property
    def least(self) -> float:
        """Mean thrust that a forced landing ends at, N."""
        return LEAST if self.motors is None else self.motors.force_landing_thrust

    def pwms(self, stamp: float, volts: float) -> Pwms:
        """What its motors are driven with."""
        duties, motors = (0.5,) * self.rotors, self.motors
        if self.armed and motors is not None:
            thrusts = np.zeros(self.rotors) if self.thrusts is None else self.thrusts
            duties = motors.duties(thrusts, volts) if motors.motors else (motors.min_pwm,) * self.rotors
        return Pwms(stamp, tuple(int(2000.0 * duty) for duty in duties))

    def pid(self) -> Gains:
        """Terms of each rotor, in thousandths."""
        terms = np.zeros((3, self.entries, 3)) if self.terms is None else self.terms
        terms = np.hstack([terms[:, :, 0].T, terms[:, :, 1].T, terms[2, :, 2:]])
        return Gains(tuple(map(tuple, np.clip(terms / _MILLI, -32768, 32767).astype(int).tolist())))

    def received(self, message: Told, now: float) -> Spinal:
        """After a message of the computer's."""
        match message:
            case FourAxes():
                return self.commanded(message, now)
            case Gains():
                return self.gained(message)
            case PMatrix():
                return self.with_p_matrix(message)
            case TorqueInverse():
                return self.with_torque_inverse(message)
            case Desire(roll, pitch, yaw):
                return self.desired(roll, pitch, yaw)
        return self.informed(message)

    def with_gimbals(self, dof: int) -> Spinal:
        """After a `gimbal_dof`, which is taken once, before it is armed."""
        fits = self.rotors * (dof + 1) <= MOST_COMPONENTS
        if dof not in (1, 2) or self.gimbal_dof or self.armed or not fits:
            return self
        return self._replace(gimbal_dof=dof, gimbals=np.zeros(self.rotors * dof))

    def informed(self, message: UavInfo | MotorInfo) -> Spinal:
        """After a `uav_info` or a `motor_info`; its number of motors is taken once."""
        if isinstance(message, MotorInfo):
            return self._replace(motors=message)
        return self._replace(uav=message) if message.motors > 0 and self.uav is None else self

    def configured(self, command: int) -> Spinal:
        """After a `flight_config_cmd`; it is not armed before it is ready."""
        if command == Arming.ON and not self.ready:
            return self
        if command in (Arming.ON, Arming.OFF):
            kept = ("rotors", "gimbal_dof", "gimbals", "uav", "motors", "p_matrix", "inertia")
            known = Spinal(**{name: getattr(self, name) for name in kept})
            return known._replace(armed=command == Arming.ON)
        if command == Arming.FORCE_LANDING:
            return self._replace(force_landing=True)
        return self._replace(integrates=_INTEGRATE.get(command, self.integrates))

    def commanded(self, message: FourAxes, now: float) -> Spinal:
        """After a `four_axes/command`; one of another number of rotors is none."""
        thrusts = np.array(message.base_thrust, dtype=float)
        finite = all(map(math.isfinite, (*message.angles, *message.base_thrust)))
        if not self.armed or thrusts.shape != (self.entries,) or not finite:
            return self
        tilted = max(abs(message.angles[0]), abs(message.angles[1])) > TILT
        if (self.force_landing or tilted) and float(thrusts.mean()) < self.least:
            return self._replace(force_landing=True)
        landing, yaw = self.force_landing or tilted, self.yaw
        if (strongest := self.strongest) is not None and self.gains is not None:
            # The computer's yaw term is that of the rotor with the largest gain; others go in proportion.
            shares = self.gains[2][:, 2]
            yaw = message.angles[2] * shares / shares[strongest]
        return self._replace(
            base=thrusts, angles=message.angles[:2], yaw=yaw, heard=now, force_landing=landing
        )

    def gained(self, message: Gains) -> Spinal:
        """After an `rpy/gain` with an entry for each rotor, or with one, of torques, for all."""
        if len(message.motors) not in (1, self.entries):
            return self
        rows = _MILLI * np.array(message.motors, dtype=float)
        zero = np.zeros(len(rows))
        p = np.stack([rows[:, 0], rows[:, 3], zero], axis=1)
        i = np.stack([rows[:, 1], rows[:, 4], zero], axis=1)
        d = np.stack([rows[:, 2], rows[:, 5], rows[:, 6]], axis=1)
        gains = np.stack([p, i, d])
        if len(rows) == self.entries:
            return self._replace(gains=gains)
        return self._replace(torque_gains=gains[:, 0])._mapped()

    def with_torque_inverse(self, message: TorqueInverse) -> Spinal:
        """After a `torque_allocation_matrix_inv`, which only an armed board takes."""
        if len(message.rows) != self.entries or not self.armed:
            return self
        return self._replace(torque_inverse=_MILLI * np.array(message.rows, dtype=float))._mapped()

    def _mapped(self) -> Spinal:
        """With gains of each rotor from those of torques; each is nothing before it came."""
        inverse = np.zeros((self.entries, 3)) if self.torque_inverse is None else self.torque_inverse
        torques = np.zeros((3, 3)) if self.torque_gains is None else self.torque_gains
        return self._replace(gains=torques[:, None, :] * inverse)

    @property
    def strongest(self) -> int | None:
        """Rotor with the largest yaw gain; only one above zero counts."""
        if self.gains is None or (shares := self.gains[2][:, 2]).max() <= 0.0:
            return None
        return int(shares.argmax())

    def with_p_matrix(self, message: PMatrix) -> Spinal:
        """After a `p_matrix_pseudo_inverse_inertia`."""
        if len(message.rows) != self.entries:
            return self
        xx, yy, zz, xy, yz, xz = (_MILLI * value for value in message.inertia)
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        return self._replace(p_matrix=_MILLI * np.array(message.rows, dtype=float), inertia=inertia)

    def desired(self, roll: float, pitch: float, yaw: float) -> Spinal:
        """After a `desire_coordinate`."""
        return self._replace(offset=np.asarray(rotation_from_rpy(roll, pitch, yaw)))
