"""Gains by which the flight controller holds the attitude itself: commands that stop tip no robot over.

It adds its own terms to the thrusts commanded of it (`attitude_loop`). What they come to is known from its
own IMU, and is taken off its command: it adds nothing to a robot that is commanded. Once no command comes
any more, what was taken off stays, and its terms hold the attitude that the robot had then.
"""

from __future__ import annotations

import numpy as np

from skylimb.analysis.exchange.messages import Desire, Gains, Imu
from skylimb.base.rotations import rot_z, rotation_from_quaternion, rotation_from_rpy, rpy_from_rotation
from skylimb.robots.posed import RobotState

STIFFNESS, DAMPING = 4.0, 0.4
"""Of roll and pitch as the flight controller holds them: natural frequency, rad/s, and damping ratio."""

FEWEST = 3
"""Rotors with which roll and pitch can be held without a change of lift."""

_MOST = 2**15 - 1
"""Thousandths that a gain has at most."""


def no_gains(rotors: int) -> Gains:
    """Those with which the flight controller adds nothing."""
    return Gains(((0,) * 7,) * rotors)


def gains_of(state: RobotState, yaw: float) -> Gains:
    """Those of a posture.

    Args:
        state: the robot's.
        yaw: of the controlled axes in C, rad.
    """
    turn = np.asarray(rot_z(-yaw))
    lift, torque = state.allocation_C[2:3], turn @ state.allocation_C[3:]
    thrusts = np.linalg.pinv(np.vstack([lift, torque[:2]]))[:, 1:]
    if len(thrusts) < FEWEST:
        return no_gains(len(thrusts))
    # Of N a rotor for an angular acceleration about roll and pitch.
    each = thrusts @ (turn @ state.inertia_C @ turn.T)[:2, :2]
    gains = np.zeros((len(each), 7))
    gains[:, [0, 3]] = STIFFNESS**2 * each
    gains[:, [2, 5]] = 2.0 * DAMPING * STIFFNESS * each
    whole = np.clip(np.rint(1e3 * gains), -_MOST, _MOST).astype(int)
    return Gains(tuple(map(tuple, whole.tolist())))


def added(gains: Gains, axes: Desire, imu: Imu) -> np.ndarray:
    """What the flight controller adds to the thrusts with targets of zero, N, (n,).

    Args:
        gains: that it has.
        axes: that are controlled, as it was set.
        imu: what it measures.
    """
    x, y, z, w = imu.quaternion_xyzw
    offset = np.asarray(rotation_from_rpy(axes.roll, axes.pitch, axes.yaw))
    roll, pitch, _ = rpy_from_rotation(rotation_from_quaternion(np.array([w, x, y, z])) @ offset.T)
    rates = offset @ np.array(imu.gyro)
    terms = np.array([roll, 0.0, rates[0], pitch, 0.0, rates[1], rates[2]])
    return -1e-3 * np.array(gains.motors, dtype=float) @ terms
