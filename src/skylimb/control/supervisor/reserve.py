"""The reserve: what is commanded where no controller does. It holds the robot level and a velocity, no more.

It knows the robot's model, and how much is left of each rotor: thrusts are the least that give lift, roll
and pitch, weighted by what is left. Yaw gives way first, as three rotors cannot hold it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from skylimb.base.packing import chosen
from skylimb.base.rotations import rotation_error, rpy_from_rotation
from skylimb.control.attitude_target import attitude_target
from skylimb.control.estimation.records import BodyState, Wrench
from skylimb.control.records import Command
from skylimb.control.supervisor.limits import Limits
from skylimb.control.supervisor.records import Sight, Watch
from skylimb.control.supervisor.table import CUT, DESCEND, RETREAT
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, clip, cross, diagonal, right_inverse, stack, vector, where, within

HOLD, LEAN, LIFT = 1.5, 0.15, (0.7, 1.2)
"""How a velocity is held, 1/s; greatest sideways and least and greatest vertical force, in weights."""

STIFFNESS, DAMPING = 25.0, 8.0
"""Of the attitude, 1/s^2 and 1/s: slow enough for the rotors' lag and the sensors' latency."""

YAW = 1e-2
"""How readily yaw gives way, m^2."""


def instead(robot: Robot, limits: Limits, watch: Watch, sight: Sight, dt: float) -> Command:
    """The command in the controller's place: its last thrusts for moments, the reserve's, or the least.

    Args:
        robot: the model.
        limits: when the supervisor acts.
        watch: what is remembered, this tick without a command counted.
        sight: of this tick.
        dt: control period, s.
    """
    low, high = robot.thrust_limits()
    external = watch.prediction.observer
    back = sight.reference.velocity * where(watch.mode > RETREAT - 0.5, 1.0, 0.0)
    wrench = Wrench(external.force, external.torque)
    reserve = reserve_thrusts(sight.body, wrench, back, watch.loss.left, (low, high))
    # A command is repeated for moments only: frozen thrusts lose the flight by themselves.
    holds = within(watch.clocks.without * dt, 0.0, limits.hold_for) * within(watch.mode, 0.0, DESCEND - 0.5)
    least = within(watch.mode, DESCEND + 0.5, CUT) + (1.0 - watch.started)
    thrusts = where(least > 0.5, low[0], where(holds > 0.5, watch.command.thrusts, reserve))
    first = Command(thrusts, sight.reference.joint_angles, sight.reference.vectoring_angles)
    return chosen(watch.started > 0.5, watch.command._replace(thrusts=thrusts), first)


def reserve_thrusts(
    body: BodyState, external: Wrench, velocity: Array, left: Array, limits: tuple[Array, Array]
) -> Array:
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
