"""Where a robot's motors could not follow what was commanded, so that nobody knows the thrusts.

Thrusts are known from their commands by the rotors' lag alone. A motor whose torque is at its limit lags
more: after half a second without motion capture, when a controller commands from 1 N to 30 N and back,
thrusts are 7 N off, and a calibration would find lag and latency eight standard deviations beside.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from skylimb.robots.model import Robot

_LAGS = 6.0
"""Lags after which a difference of speeds is forgotten."""


def followed(command: np.ndarray, dt: float, robot: Robot) -> np.ndarray:
    """Whether every motor follows at each tick, and has followed for some lags before, (k,).

    Args:
        command: thrusts, N, (k, n).
        dt: control period, s.
        robot: as it is described; rotors without thrust factor, inertia or torque limit follow anything.
    """
    follows = np.ones(len(command), dtype=bool)
    for rotor, thrusts in zip(robot.description.rotors, command.T, strict=True):
        if rotor.thrust_factor is None or not rotor.inertia or rotor.lag <= 0.0:
            continue
        wanted = np.sqrt(np.clip(thrusts, 0.0, rotor.thrust_max) / rotor.thrust_factor)
        left = float(np.exp(-dt / rotor.lag))
        speed = wanted[0] + np.asarray(lfilter([0.0, 1.0 - left], [1.0, -left], wanted - wanted[0]))
        drag = abs(rotor.drag_torque_coefficient) * rotor.thrust_factor * speed**2
        torque = rotor.inertia * (wanted - speed) * (1.0 - left) / dt + drag
        for tick in np.flatnonzero(np.abs(torque) > rotor.torque_max):
            follows[tick : tick + 1 + round(_LAGS * rotor.lag / dt)] = False
    return follows
