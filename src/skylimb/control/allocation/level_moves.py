"""Vectoring angles that give the whole side force, so that the body need not tilt for it.

The hovering frame {C} turns with the vectoring angles until the hover thrusts lie along its z axis. So a side
force without a tilt of the body is a tilt of {C} in the body. The angles are found as in
`allocation.lateral`, one Gauss-Newton step a tick from the nominal ones,

    d_psi = J^+ (f_xy - h(psi) + J d_psi) - (E - J^+ J) (k g + s c),      J^+ = J^T (J J^T + mu E)^-1,

and used for more: of all moves that give the force, the first term is the least one, which keeps the joints'
travel, and the second goes down the rotors' effort g in the null space, which keeps their margin, and down
how far the thrusts are from those of the hover, c. Rotors that are stronger or weaker than the model were
made up for in the hover; what they do to the wrench afterwards grows with the change of their thrusts. What
the limits of the angles leave out is returned, as only a tilt can give it.
"""

from __future__ import annotations

import functools
import math
from typing import Annotated, Any, NamedTuple

import casadi as ca

from skylimb.base.keys import Key, configuration
from skylimb.base.rotations import rot_z, rpy_from_rotation
from skylimb.control.allocation.lateral import least_move, side_force_function
from skylimb.control.box_least_squares import nearest_in_box
from skylimb.control.estimation.records import BodyState
from skylimb.control.records import Demand, LawInput
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, as_numpy, clip, low_pass, stack

_CALM = 2.0 * math.pi * 0.3
"""Rate of the pull toward the thrusts of the hover, 1/s: slow, as servos that chase it tick by tick shake."""

_MOST = 2.0
"""Greatest such pull over the greatest move: where thrusts are nearly undetermined it would have no bound."""


@configuration
class LevelMoves:
    """How far and how fast the vectoring angles move, and what they are good for besides."""

    limit: Annotated[float, Key("rad", "greatest move of an angle", above=0.0, high=3.2)] = 1.2
    rate: Annotated[float, Key("rad/s", "greatest speed of a move", above=0.0, high=100.0)] = 4.0
    damping: Annotated[
        float,
        Key("N^2/rad^2", "mu, which keeps moves small where they do little", above=0.0, high=1e6),
    ] = 0.5
    cutoff: Annotated[
        float,
        Key("Hz", "cut-off of the low pass on the moves, as the wanted force is noisy", above=0.0, high=1e4),
    ] = 4.0
    lead: Annotated[
        float, Key("", "how many times faster than by their servos the angles follow", low=1.0, high=10.0)
    ] = 1.0
    margin: Annotated[
        float,
        Key(
            "rad^2",
            "k, how far moves that change no force go for the margin of the thrusts; 0 for the least moves",
            low=0.0,
            high=1.0,
        ),
    ] = 1.0
    steady: Annotated[
        float,
        Key(
            "rad^2",
            "s, how far moves that change no force go to keep each thrust as in the hover, where rotors that "
            "differ from the model were made up for; 0 for the least moves",
            low=0.0,
            high=100.0,
        ),
    ] = 0.0


class Moved(NamedTuple):
    """What the angles do for the side force.

    Attributes:
        move: of the vectoring angles from the nominal ones, rad, (nv,).
        pull: toward the thrusts of the hover, low-passed, rad, (nv,).
        short: force that the move cannot give, W, N, (3,).
    """

    move: Array
    pull: Array
    short: Array


def level_move(gains: Any, move: Array, pull: Array, inputs: LawInput, demand: Demand) -> Moved:
    """The move that gives the side force with the body level.

    Args:
        gains: a `LevelMoves`.
        move: of the last tick, rad, (nv,).
        pull: of the last tick, rad, (nv,).
        inputs: of this tick.
        demand: force, torque and nominal vectoring angles.
    """
    nominal, q = demand.vectoring_angles, inputs.measurement.joint_angles
    body = inputs.estimate.body
    R_WN = nominal_rotation(inputs.robot, body, q, nominal)
    force, torque = R_WN.T @ demand.force, R_WN.T @ (body.R_WC @ demand.torque)
    found = side_force_function(inputs.robot)(q, nominal, nominal + move, force[2], torque)
    side, J, effort, change = map(as_numpy, found)
    wanted = force[0:2] - side + J @ move
    most = _MOST * gains.limit
    pull = low_pass(pull, clip(gains.steady * change, -most, most), _CALM, inputs.dt)
    away = gains.margin * effort + pull
    free = least_move(J, gains.damping, wanted + J @ away) - away
    lower, upper = inputs.robot.vectoring_limits()
    lower, upper = (clip(limit - nominal, -gains.limit, gains.limit) for limit in (lower, upper))
    new = _within(J, gains.damping, free, lower, upper)
    short = R_WN @ stack(J @ (free - new), 0.0)
    new = low_pass(move, new, 2.0 * math.pi * gains.cutoff, inputs.dt)
    step = gains.rate * inputs.dt
    return Moved(clip(new, move - step, move + step), pull, short)


def nominal_rotation(robot: Robot, body: BodyState, joint_angles: Array, nominal: Array) -> Array:
    """R_WN, (3, 3): attitude of the hovering frame as it would be at the nominal vectoring angles.

    Args:
        robot: the controller's model.
        body: attitude of {C} at the measured angles.
        joint_angles: measured, rad.
        nominal: vectoring angles, rad.
    """
    return body.R_WC @ body.model.R_root_C.T @ as_numpy(_hovering_frame(robot)(joint_angles, nominal))


def aim_level(robot: Robot, body: BodyState, joint_angles: Array, nominal: Array, force: Array) -> Array:
    """The force along which z of {C} lies while the body is level, W, N, (3,).

    Args:
        robot: the controller's model.
        body: attitude of {C} at the measured angles.
        joint_angles: measured, rad.
        nominal: vectoring angles at which the body hovers level, rad.
        force: whose upright part it has, W, N, (3,).
    """
    # Where z of {C} lies in the level body, turned to the body's heading.
    up = nominal_rotation(robot, body, joint_angles, nominal).T @ body.R_WC[:, 2]
    return rot_z(rpy_from_rotation(body.R_WC)[2]) @ up * (force[2] / up[2])


def _within(J: Array, damping: Any, free: Array, lower: Array, upper: Array) -> Array:
    """The move within its limits whose side force is nearest to that of a free one, rad, (nv,).

    Where an angle is at its limit, the others make up for it.
    """
    count = J.shape[1]
    rows = ca.vertcat(J, ca.DM.eye(count) * damping**0.5)
    new, _ = nearest_in_box(2 + count, count)(rows, free, lower, upper)
    return as_numpy(new)


@functools.lru_cache(maxsize=16)
def _hovering_frame(robot: Robot) -> ca.Function:
    """(q, psi) -> R_root_C, (3, 3)."""
    q, psi = ca.SX.sym("q", robot.n_joints), ca.SX.sym("psi", robot.n_vectoring)
    return ca.Function("hovering_frame", [q, psi], [robot.model(q, psi).R_root_C])
