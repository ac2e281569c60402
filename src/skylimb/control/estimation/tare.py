"""Tare: the observer's bias, averaged in free flight and taken off afterwards.

One degree of attitude error reads as 0.6 N and uneven rotors as a few tenths, as large as the contact force
itself. Both belong to the body, so the force bias is kept in the heading frame (W turned by the robot's yaw)
and turns with the robot.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from skylimb.base.rotations import rot_z
from skylimb.control.estimation.records import Wrench
from skylimb.symbolic import Array


class TareState(NamedTuple):
    """Mean of the free-flight estimate: force in the heading frame (N), torque in C (N m), ticks so far."""

    force: Array = np.zeros(3)
    torque: Array = np.zeros(3)
    ticks: float | Array = 0.0


def tare(state: TareState, raw: Wrench, yaw: Array, collecting: Array) -> tuple[TareState, Wrench]:
    """Average while `collecting` is 1; take the bias known so far off the raw estimate.

    Args:
        state: the mean so far.
        raw: the observer's estimate.
        yaw: heading of C in W, rad.
        collecting: 1 in the tare phase, else 0.

    Returns:
        The new state and the tared wrench (force in W, torque in C).
    """
    R = rot_z(yaw)
    ticks = state.ticks + collecting
    # A mean of nothing is zero: before the first collected tick the weight is zero too.
    weight = collecting / (ticks + (1.0 - collecting))
    force = state.force + (R.T @ raw.force - state.force) * weight
    torque = state.torque + (raw.torque - state.torque) * weight
    return TareState(force, torque, ticks), Wrench(raw.force - R @ force, raw.torque - torque)
