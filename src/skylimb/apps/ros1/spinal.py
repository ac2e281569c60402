"""The attitude loop of the lab's flight controller, as it runs on board: thrusts of base thrusts and gains.

    thrust_i = base_i + roll and pitch terms_i + gyro term_i + yaw term_i

Failsafe, forced landing and what gives way where a motor cannot (yaw, or all base thrusts alike) are its own.
Numbers of messages are thousandths, as they travel.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from skylimb.analysis.exchange.messages import (
    FourAxes,
    Gains,
    MotorInfo,
    PMatrix,
    Pwms,
    TorqueInverse,
    UavInfo,
)
from skylimb.apps.ros1.states import Arming
from skylimb.base.rotations import rotation_from_rpy, rpy_from_rotation

SILENCE = 0.5
"""Seconds without a command after which it lands by force."""

TILT = 1.0
"""Roll or pitch, measured or commanded, beyond which it does, rad."""

FALLING, LEAST = 2.5, 7.0
"""Of a forced landing: what the mean base thrust loses, N/s, and what it ends at where nobody says, N."""

_MILLI = 1e-3
_INTEGRATE = {160: True, 161: False}


@dataclass(frozen=True)
class Spinal:
    """All that it remembers.

    Attributes:
        rotors: how many.
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
    """

    rotors: int
    uav: UavInfo | None = None
    motors: MotorInfo | None = None
    armed: bool = False
    force_landing: bool = False
    integrates: bool = False
    heard: float | None = None
    base: np.ndarray = field(default_factory=lambda: np.zeros(0))
    angles: tuple[float, float] = (0.0, 0.0)
    yaw: np.ndarray = field(default_factory=lambda: np.zeros(0))
    gains: np.ndarray | None = None
    torque_gains: np.ndarray | None = None
    torque_inverse: np.ndarray | None = None
    p_matrix: np.ndarray | None = None
    inertia: np.ndarray | None = None
    offset: np.ndarray | None = None
    integral: tuple[float, float] = (0.0, 0.0)

    @property
    def ready(self) -> bool:
        """Whether it may be armed: it knows how many motors it has, and their range of duty."""
        motors = self.motors
        return self.uav is not None and motors is not None and motors.max_pwm > motors.min_pwm

    @property
    def least(self) -> float:
        """Mean thrust that a forced landing ends at, N."""
        return LEAST if self.motors is None else self.motors.force_landing_thrust

    def pwms(self, stamp: float) -> Pwms:
        """What its motors are driven with, as far as anybody reads it: whether they turn at all."""
        duty = self.motors.min_pwm if self.armed and self.motors is not None else 0.5
        return Pwms(stamp, (round(2000.0 * duty),) * self.rotors)

    def informed(self, message: UavInfo | MotorInfo) -> Spinal:
        """After a `uav_info` or a `motor_info`; its number of motors is taken once."""
        if isinstance(message, MotorInfo):
            return replace(self, motors=message)
        return replace(self, uav=message) if message.motors > 0 and self.uav is None else self

    def configured(self, command: int) -> Spinal:
        """After a `flight_config_cmd`; it is not armed before it is ready."""
        if command == Arming.ON and not self.ready:
            return self
        if command in (Arming.ON, Arming.OFF):
            known = Spinal(self.rotors, self.uav, self.motors, p_matrix=self.p_matrix, inertia=self.inertia)
            return replace(known, armed=command == Arming.ON)
        if command == Arming.FORCE_LANDING:
            return replace(self, force_landing=True)
        return replace(self, integrates=_INTEGRATE.get(command, self.integrates))

    def commanded(self, message: FourAxes, now: float) -> Spinal:
        """After a `four_axes/command`; one of another number of rotors is none."""
        thrusts = np.array(message.base_thrust, dtype=float)
        numbers = np.array([*message.angles, *thrusts])
        if not self.armed or thrusts.shape != (self.rotors,) or not np.isfinite(numbers).all():
            return self
        tilted = max(abs(message.angles[0]), abs(message.angles[1])) > TILT
        if (self.force_landing or tilted) and float(thrusts.mean()) < self.least:
            return replace(self, force_landing=True)
        landing, yaw = self.force_landing or tilted, self.yaw
        if (strongest := self._strongest) is not None and self.gains is not None:
            # The computer's yaw term is that of the rotor with the largest gain; others go in proportion.
            shares = self.gains[2][:, 2]
            yaw = message.angles[2] * shares / shares[strongest]
        return replace(
            self, base=thrusts, angles=message.angles[:2], yaw=yaw, heard=now, force_landing=landing
        )

    def gained(self, message: Gains) -> Spinal:
        """After an `rpy/gain` with an entry for each rotor, or with one, of torques, for all."""
        if len(message.motors) not in (1, self.rotors):
            return self
        rows = _MILLI * np.array(message.motors, dtype=float)
        zero = np.zeros(len(rows))
        p = np.stack([rows[:, 0], rows[:, 3], zero], axis=1)
        i = np.stack([rows[:, 1], rows[:, 4], zero], axis=1)
        d = np.stack([rows[:, 2], rows[:, 5], rows[:, 6]], axis=1)
        gains = np.stack([p, i, d])
        if len(rows) == self.rotors:
            return replace(self, gains=gains)
        return replace(self, torque_gains=gains[:, 0])._mapped()

    def with_torque_inverse(self, message: TorqueInverse) -> Spinal:
        """After a `torque_allocation_matrix_inv`, which only an armed board takes."""
        if len(message.rows) != self.rotors or not self.armed:
            return self
        return replace(self, torque_inverse=_MILLI * np.array(message.rows, dtype=float))._mapped()

    def _mapped(self) -> Spinal:
        """With gains of each rotor from those of torques; each is nothing before it came."""
        inverse = np.zeros((self.rotors, 3)) if self.torque_inverse is None else self.torque_inverse
        torques = np.zeros((3, 3)) if self.torque_gains is None else self.torque_gains
        return replace(self, gains=torques[:, None, :] * inverse)

    @property
    def _strongest(self) -> int | None:
        """Rotor with the largest yaw gain; only one above zero counts."""
        if self.gains is None or (shares := self.gains[2][:, 2]).max() <= 0.0:
            return None
        return int(shares.argmax())

    def with_p_matrix(self, message: PMatrix) -> Spinal:
        """After a `p_matrix_pseudo_inverse_inertia`."""
        if len(message.rows) != self.rotors:
            return self
        xx, yy, zz, xy, yz, xz = (_MILLI * value for value in message.inertia)
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        return replace(self, p_matrix=_MILLI * np.array(message.rows, dtype=float), inertia=inertia)

    def desired(self, roll: float, pitch: float, yaw: float) -> Spinal:
        """After a `desire_coordinate`."""
        return replace(self, offset=np.asarray(rotation_from_rpy(roll, pitch, yaw)))


def attitude_loop(
    spinal: Spinal,
    R: np.ndarray,
    rates: np.ndarray,
    now: float,
    dt: float,
    limits: tuple[np.ndarray, np.ndarray],
) -> tuple[Spinal, np.ndarray]:
    """One pass.

    Args:
        spinal: as it was.
        R: axes of the board in W, (3, 3).
        rates: in them, rad/s, (3,).
        now: s.
        dt: since the last pass, s.
        limits: of the thrusts, N, (n,) each.

    Returns:
        It, and the thrusts, N, (n,): zero where the motors are off.
    """
    heard = spinal.heard
    if not spinal.armed or heard is None:
        return spinal, np.zeros(spinal.rotors)
    offset = np.eye(3) if spinal.offset is None else spinal.offset
    R, rates = R @ offset.T, offset @ rates
    attitude = np.asarray(rpy_from_rotation(R), dtype=float)
    if not spinal.force_landing and np.abs(attitude[:2]).max() > TILT:
        spinal = replace(spinal, force_landing=True, integral=(0.0, 0.0))
    if spinal.force_landing or now - heard > SILENCE:
        spinal = replace(spinal, force_landing=True, angles=(0.0, 0.0), yaw=np.zeros(spinal.rotors))
    base = spinal.base
    if spinal.force_landing and float(base.mean()) > spinal.least:
        base = base * (1.0 - FALLING * dt / float(base.mean()))
        spinal = replace(spinal, base=base)
    error = np.array([*(spinal.angles - attitude[:2]), 0.0])
    integral = np.array([*spinal.integral, 0.0]) + (error * dt if spinal.integrates else 0.0)
    spinal = replace(spinal, integral=(float(integral[0]), float(integral[1])))
    return spinal, np.clip(_saturated(spinal, *_terms(spinal, error, integral, rates)), *limits)


def _terms(
    spinal: Spinal, error: np.ndarray, integral: np.ndarray, rates: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """What roll, pitch and gyro add to the base thrusts, and what yaw does, N, (n,) each."""
    level, yaw = np.zeros(spinal.rotors), np.zeros(spinal.rotors)
    if spinal.gains is not None:
        p, i, d = spinal.gains
        level = p @ error + i @ integral - d[:, :2] @ rates[:2]
        yaw = -d[:, 2] * rates[2]
    if spinal.p_matrix is not None and spinal.inertia is not None:
        level = level + spinal.p_matrix @ np.cross(rates, spinal.inertia @ rates)
    return level, yaw + spinal.yaw if len(spinal.yaw) else yaw


def _saturated(spinal: Spinal, level: np.ndarray, yaw: np.ndarray) -> np.ndarray:
    """Thrusts, N, (n,), after what gives way: yaw where a motor would leave its range, then the base thrusts.

    It knows motors as `motor_info` says them, whatever they really can.
    """
    base, motors = spinal.base, spinal.motors
    asked = base + level
    if motors is None or not motors.motors:
        return asked + yaw
    highest, lowest = int(asked.argmax()), int(asked.argmin())
    above = motors.motors[0].max_thrust - asked[highest]
    below = asked[lowest] - motors.min_thrust
    if above < 0.0 and base[highest] > 0.0:
        return asked + base * above / base[highest]
    if spinal._strongest is None or base[0] == 0.0:
        return asked
    missing, rotor = (-below, lowest) if below < above else (-above, highest)
    if missing > 0.0:
        yaw = yaw * (1.0 - min(1.0, missing / abs(yaw[rotor]) if yaw[rotor] else 1.0))
    return asked + yaw
