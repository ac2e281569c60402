"""The reserve: what flies where no controller does. It holds the robot level and a velocity, no more.

It knows the robot's model, and how much is left of each rotor: thrusts are the least that give lift, roll
and pitch, weighted by what is left. Yaw gives way first, as three rotors cannot hold it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from skylimb.base.rotations import rotation_error, rpy_from_rotation
from skylimb.control.attitude_target import attitude_target
from skylimb.control.estimation.records import BodyState, Wrench
from skylimb.control.thrusts import Limits
from skylimb.symbolic import Array, clip, cross, diagonal, right_inverse, stack, vector

HOLD, LEAN, LIFT = 1.5, 0.15, (0.7, 1.2)
"""How a velocity is held, 1/s; greatest sideways and least and greatest vertical force, in weights."""

STIFFNESS, DAMPING = 25.0, 8.0
"""Of the attitude, 1/s^2 and 1/s: slow enough for the rotors' lag and the sensors' latency."""

YAW = 1e-2
"""How readily yaw gives way, m^2."""


def reserve_thrusts(body: BodyState, external: Wrench, velocity: Array, left: Array, limits: Limits) -> Array:
    """Thrusts of a tick, N, (n,).

    Args:
        body: state of {C}.
        external: the wrench that is believed to act.
        velocity: that is to be held, W, m/s, (3,).
        left: share that each rotor has left, (n,).
        limits: of the thrusts, N.
    """
    model, weight = body.model, body.model.mass * body.model.gravity[2]
    pull = model.mass * HOLD * (velocity - body.velocity) - external.force
    force = vector(
        clip(pull[0], -LEAN * weight, LEAN * weight),
        clip(pull[1], -LEAN * weight, LEAN * weight),
        clip(weight + pull[2], LIFT[0] * weight, LIFT[1] * weight),
    )
    yaw = rpy_from_rotation(body.R_WC)[2]
    _, target = attitude_target(force, yaw, yaw)
    omega = body.angular_velocity
    spring = DAMPING * omega + STIFFNESS * rotation_error(body.R_WC, target)
    torque = cross(omega, model.inertia_C @ omega) - model.inertia_C @ spring - external.torque
    lift = body.R_WC[:, 2].T @ force
    Q, W = model.allocation_C[2:, :], diagonal(left * left)
    square: Any = Q @ W @ Q.T + np.diag([0.0, 0.0, 0.0, YAW])
    thrusts = W @ (Q.T @ (right_inverse(square) @ stack(lift, torque)))
    return clip(thrusts, limits[0], limits[1])
