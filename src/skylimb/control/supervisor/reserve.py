"""The reserve: what is commanded where no controller does. It holds the robot level and a velocity, no more.

It knows the robot's model, and how much is left of each rotor: thrusts are the least that give lift, roll
and pitch, weighted by what is left. Yaw gives way first, as three rotors cannot hold it, then lift. Level is
the attitude in which those thrusts push up: with three rotors it is a lean. Without one of them its
vectoring angles go where the others carry it; while one of these is at its limit, they go where they push it
upright and against its speed. While it is seen it keeps to the place where it comes down.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from skylimb.base.packing import chosen
from skylimb.control.box_least_squares import nearest_in_box
from skylimb.control.estimation.records import BodyState, Wrench
from skylimb.control.records import Command
from skylimb.control.supervisor.balance import balanced
from skylimb.control.supervisor.descents import Descents
from skylimb.control.supervisor.limits import Limits
from skylimb.control.supervisor.records import Sight, Watch
from skylimb.control.supervisor.table import CUT, DESCEND, RETREAT, TABLE
from skylimb.robots.model import Robot
from skylimb.symbolic import (
    Array,
    clip,
    cross,
    diagonal,
    dot,
    is_symbolic,
    matrix,
    max,
    norm,
    right_inverse,
    stack,
    vector,
    where,
    within,
)

LIFT = 0.7, 1.2
"""Least and greatest vertical force, in weights."""


class Firmness(NamedTuple):
    """How firmly it holds.

    Attributes:
        hold: of a velocity, 1/s.
        lean: greatest sideways force, in weights.
        stiffness: of the attitude, 1/s^2.
        damping: of the attitude, 1/s.
        lead: how much of a change of thrust is commanded at once, as rotors lag.
    """

    hold: float
    lean: float
    stiffness: float
    damping: float
    lead: float


SOFT = Firmness(hold=1.5, lean=0.15, stiffness=25.0, damping=8.0, lead=1.0)
"""Slow enough for a motion capture whose velocity is off by 0.1 m/s."""

FIRM = Firmness(hold=2.0, lean=0.25, stiffness=36.0, damping=10.0, lead=2.0)
"""Where losses are looked for: without a rotor it would have tilted by 15 degrees in 0.2 s."""

YAW = 1e-2
"""How readily yaw gives way, (rad/s^2)^2/N^2."""

COUNTS = np.array([0.03, 1.0, 1.0, 1e-3])
"""What 1 N of lift and 1 rad/s^2 of roll, pitch and yaw count where a thrust is at its limit."""

SPENT = 0.95
"""Share of its greatest thrust from which a rotor counts as one at its limit."""

PLACE, RETURN = 0.5, 0.5
"""How a place is held, 1/s, and the greatest speed on the way back to it, m/s."""

_STALE = list(TABLE.bits).index("stale")


def instead(
    robot: Robot, limits: Limits, descents: Descents, watch: Watch, sight: Sight, dt: float
) -> Command:
    """The command in the controller's place: its last thrusts for moments, the reserve's, or the least.

    Args:
        robot: the model.
        limits: when the supervisor acts.
        descents: for the loss of each rotor.
        watch: what is remembered, this tick without a command counted.
        sight: of this tick.
        dt: control period, s.
    """
    low, high = robot.thrust_limits()
    external = watch.prediction.observer
    back = sight.reference.velocity * where(watch.mode > RETREAT - 0.5, 1.0, 0.0)
    wrench = Wrench(external.force, external.torque)
    left, rotors = watch.loss.left, watch.prediction.thrusts
    known = (1.0 - sight.bits[_STALE]) * within(watch.mode, DESCEND, CUT)
    astray = sight.reference.position - sight.body.position
    home = vector(*(clip(PLACE * astray[axis], -RETURN, RETURN) for axis in range(2)), 0.0)
    firm = FIRM if limits.losses else SOFT
    force = reserve_force(sight.body, wrench, back + known * home, firm)
    reserve = reserve_thrusts(sight.body, wrench, force, left, rotors, (low, high), firm)
    # A command is repeated for moments only: frozen thrusts lose the flight by themselves.
    holds = within(watch.clocks.without * dt, 0.0, limits.hold_for) * within(watch.mode, 0.0, DESCEND - 0.5)
    least = within(watch.mode, DESCEND + 0.5, CUT) + (1.0 - watch.started)
    thrusts = where(least > 0.5, low[0], where(holds > 0.5, watch.command.thrusts, reserve))
    first = Command(thrusts, sight.reference.joint_angles, sight.reference.vectoring_angles)
    last = watch.command.vectoring_angles
    angles = descents.followed(left, watch.loose, last, dt)
    if limits.losses:
        speeds, loose = watch.prediction.rates.rates, descents.unanswered(watch.loose)
        there = where(left > 0.0, 1.0, 0.0)
        # Without a rotor, and with another one at its limit, thrusts turn it back no more.
        spent = max(1.0 - there) * max(where(rotors > SPENT * high, 1.0, 0.0))
        push = where(spent > 0.5, sight.body.R_WC.T @ force, vector(0.0, 0.0, robot.weight))
        angles = where(spent > 0.5, last, angles)
        strayed, seen = max(stack(watch.strayed, spent)), sight.measurement
        angles = balanced(robot, loose, strayed, there, seen, speeds, watch.axes, push, angles, dt)
    return chosen(
        watch.started > 0.5, watch.command._replace(thrusts=thrusts, vectoring_angles=angles), first
    )


def reserve_force(body: BodyState, external: Wrench, velocity: Array, firm: Firmness) -> Array:
    """The force that the rotors are to give, W, N, (3,).

    Args:
        body: state of {C}.
        external: the wrench that is believed to act.
        velocity: that is to be held, W, m/s, (3,).
        firm: how firmly it is.
    """
    model, weight = body.model, body.model.mass * body.model.gravity[2]
    pull, lean = model.mass * firm.hold * (velocity - body.velocity) - external.force, firm.lean * weight
    return vector(
        clip(pull[0], -lean, lean),
        clip(pull[1], -lean, lean),
        clip(weight + pull[2], LIFT[0] * weight, LIFT[1] * weight),
    )


def reserve_thrusts(
    body: BodyState,
    external: Wrench,
    force: Array,
    left: Array,
    made: Array,
    limits: tuple[Array, Array],
    firm: Firmness = SOFT,
) -> Array:
    """Thrusts of a tick, N, (n,).

    Args:
        body: state of {C}.
        external: the wrench that is believed to act.
        force: of the rotors, W, N, (3,).
        left: share that each rotor has left, (n,).
        made: thrusts that the rotors make now, behind their lag, N, (n,).
        limits: of the thrusts, N.
        firm: how firmly it holds.
    """
    model = body.model
    # Lift, N, and turns, rad/s^2: yaw that is not given must not turn the robot about another axis.
    spin = right_inverse(model.inertia_C)
    turns = ([0.0, *(spin[i, j] for j in range(3))] for i in range(3))
    given = model.allocation_C @ diagonal(left)
    Q = matrix([[1.0, 0.0, 0.0, 0.0], *turns]) @ given[2:, :]
    square: Any = Q @ Q.T + np.diag([0.0, 0.0, 0.0, YAW])
    thrusts = Q.T @ right_inverse(square)
    up = given[:3, :] @ thrusts[:, 0]
    up, wanted, omega = up / norm(up), body.R_WC.T @ force, body.angular_velocity
    turn = firm.stiffness * cross(up, wanted) / norm(wanted) - firm.damping * (omega - dot(up, omega) * up)
    turn = turn + spin @ (cross(omega, model.inertia_C @ omega) - external.torque)
    aimed = thrusts @ stack(dot(up, wanted) * up[2], turn)
    total, _ = nearest_in_box(4, aimed.shape[0])(diagonal(COUNTS) @ Q, aimed, *limits)
    total = total if is_symbolic(aimed) else total.full().ravel()
    return clip(made + firm.lead * (total - made), limits[0], limits[1])
