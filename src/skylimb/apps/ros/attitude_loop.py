"""One pass of the board's attitude loop: thrusts of base thrusts, gains and what is measured.

    thrust_i = base_i + roll and pitch terms_i + gyro term_i + yaw term_i

What gives way where a motor cannot (yaw, or all base thrusts alike) is the board's own rule, and so are
failsafe and forced landing.
"""

from __future__ import annotations

import numpy as np

from skylimb.apps.ros.spinal import TILT, Spinal
from skylimb.base.rotations import rpy_from_rotation
from skylimb.symbolic import cross

SILENCE = 0.5
"""Seconds without a command after which it lands by force."""

FALLING = 2.5
"""What the mean base thrust loses in a forced landing, N/s."""


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
    roll, pitch, _ = rpy_from_rotation(R).tolist()
    if not spinal.force_landing and max(abs(roll), abs(pitch)) > TILT:
        spinal = spinal._replace(force_landing=True, integral=(0.0, 0.0))
    if spinal.force_landing or now - heard > SILENCE:
        spinal = spinal._replace(force_landing=True, angles=(0.0, 0.0), yaw=np.zeros(spinal.entries))
    base = spinal.base
    if spinal.force_landing and float(base.mean()) > spinal.least:
        base = base * (1.0 - FALLING * dt / float(base.mean()))
        spinal = spinal._replace(base=base)
    error = np.array([spinal.angles[0] - roll, spinal.angles[1] - pitch, 0.0])
    integral = np.array([*spinal.integral, 0.0]) + (error * dt if spinal.integrates else 0.0)
    gains = np.zeros((3, spinal.entries, 3)) if spinal.gains is None else spinal.gains
    terms = gains * np.array([error, integral, -rates])[:, None]
    asked = _saturated(spinal, *_terms(spinal, terms, rates))
    integrated = float(integral[0]), float(integral[1])
    thrusts, gimbals = _turned(spinal, asked)
    spinal = spinal._replace(integral=integrated, terms=terms, thrusts=thrusts, gimbals=gimbals)
    return spinal, thrusts.clip(*limits)


def forced_by(spinal: Spinal, now: float) -> str:
    """Why it lands by force, in words; `now`, s, is the end of the tick in which that began."""
    if spinal.heard is not None and now - spinal.heard > SILENCE:
        return f"no command for {SILENCE:g} s"
    return f"commanded, or tilted by more than {TILT:g} rad"


def _turned(spinal: Spinal, asked: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Thrusts, N, (n,), and angles of the rotors that the board turns, half of the way at each pass, rad."""
    if not spinal.gimbal_dof:
        return asked, spinal.gimbals
    x, *y, z = forces = asked.reshape(spinal.rotors, -1).T
    roll = np.arctan2(-y[0] if y else -x, z)
    angles = [roll, np.arctan2(x, np.hypot(y[0], z))] if y else [roll]
    return np.linalg.norm(forces, axis=0), 0.5 * (spinal.gimbals + np.stack(angles, axis=1).ravel())


def _terms(spinal: Spinal, terms: np.ndarray, rates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What roll, pitch and gyro add to the base thrusts, and what yaw does, N, (n,) each."""
    level, yaw = terms[:, :, :2].sum(axis=(0, 2)), terms[2, :, 2]
    if spinal.p_matrix is not None and spinal.inertia is not None:
        level = level + spinal.p_matrix @ cross(rates, spinal.inertia @ rates)
    return level, yaw + spinal.yaw if len(spinal.yaw) else yaw


def _saturated(spinal: Spinal, level: np.ndarray, yaw: np.ndarray) -> np.ndarray:
    """Thrusts, N, (n,), after what gives way: yaw where a motor would leave its range, then the base thrusts.

    It knows motors as `motor_info` says them, whatever they really can.
    """
    base, motors = spinal.base, spinal.motors
    asked = base + level
    if motors is None or not motors.motors:
        return asked + yaw
    sizes = np.linalg.norm(asked.reshape(spinal.rotors, -1), axis=1) if spinal.gimbal_dof else asked
    # The board counts rotors here and components there, whatever it turns.
    highest, lowest = int(sizes.argmax()), int(sizes.argmin())
    above = motors.motors[0].max_thrust - sizes[highest]
    below = sizes[lowest] - motors.min_thrust
    if above < 0.0 and base[highest] > 0.0:
        return asked + base * above / base[highest]
    if spinal.strongest is None or base[0] == 0.0:
        return asked
    missing, rotor = (-below, lowest) if below < above else (-above, highest)
    if missing > 0.0:
        yaw = yaw * (1.0 - min(1.0, missing / abs(yaw[rotor]) if yaw[rotor] else 1.0))
    return asked + yaw
