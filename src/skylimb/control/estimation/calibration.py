"""Calibration in flight: what the bias in a hover says about the sensors and the robot.

In free flight nothing pushes, so all that the observer sees is an error of the model. Its first order is
geometric, with F = m g the hover thrust along z of {C}:

- a measured body that is turned by a small e against the real one makes the rotors push sideways in the
  model's eyes, f = -e x F z, so e = (f_y, -f_x) / F about the level axes;
- a centre of gravity that lies d away from the modelled one makes the thrust turn the robot,
  tau = -d x F z, so d = (tau_y, -tau_x) / F.

A turn about the vertical and the height of the centre of gravity are invisible. Rotors that differ from the
model by 2 % each read as about 3 mm of d; a hover cannot tell the two apart.

Rotors that all push more or less than they are told move the robot long before a tare is over. So up to the
tare it is trimmed: what is felt along its weight in free flight is fed at once, within `TRIM` of the weight.
A robot that needs more than `SOUND` has something wrong with it, and touches nothing.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

from skylimb.base.keys import Key, configuration
from skylimb.base.rotations import rot_z
from skylimb.control.estimation.records import BodyState, Wrench
from skylimb.control.estimation.tare import TareState
from skylimb.robots.model import RobotState
from skylimb.symbolic import Array, clip, cross, exp, vector, where

TRIM, SOUND = 0.25, 0.12
"""Shares of the weight: the most that is fed before the tare, and that with which a robot may still touch."""


@configuration
class Calibration:
    """What is done with the hover's bias."""

    feed: Annotated[bool, Key("", "whether the rotors make up the bias, so that no error has to")] = False
    attitude: Annotated[bool, Key("", "whether the measured attitude is corrected")] = False
    cog: Annotated[bool, Key("", "whether the modelled centre of gravity is corrected")] = False
    rate: Annotated[
        float, Key("1/s", "rate at which corrections come in after the tare", above=0.0, high=100.0)
    ] = 1.0


class Correction(NamedTuple):
    """What is in force; nothing without arguments.

    Attributes:
        force: bias in the heading frame, N, (3,).
        torque: bias in C, N m, (3,).
    """

    force: Array = vector(0.0, 0.0, 0.0)
    torque: Array = vector(0.0, 0.0, 0.0)


def follow_bias(gains: Any, state: Correction, tare: TareState, collecting: Any, dt: float) -> Correction:
    """Let the bias in once it is known and no longer averaged."""
    step = (1.0 - exp(-gains.rate * dt)) * (1.0 - collecting)
    return Correction(
        state.force + step * (tare.force - state.force), state.torque + step * (tare.torque - state.torque)
    )


def trimmed(state: Correction, felt: Wrench, model: RobotState, known: Any) -> Correction:
    """With what is felt along the weight in force at once, until the bias itself is known.

    Args:
        state: what is in force.
        felt: the observer's wrench, bias and all.
        model: gives the weight.
        known: above 0 once a tare or a touch has begun.
    """
    most = TRIM * model.mass * model.gravity[2]
    up = where(known > 0.5, state.force[2], clip(felt.force[2], -most, most))
    return state._replace(force=vector(state.force[0], state.force[1], up))


def is_sound(bias: Wrench, model: RobotState) -> Any:
    """1 for a robot whose bias leaves it fit to touch a surface, else 0."""
    return where(abs(bias.force[2]) > SOUND * model.mass * model.gravity[2], 0.0, 1.0)


def calibrated(gains: Any, state: Correction, body: BodyState) -> tuple[BodyState, Array]:
    """The body's state with attitude and centre of gravity put right, and the arm.

    Only places are corrected: attitude control and observer see the measured attitude, whose error the fed
    bias makes up.

    Args:
        gains: a `Calibration`.
        state: what is in force.
        body: as measured.

    Returns:
        The state, and the vector from the centre of gravity to the tip in W, m, (3,).
    """
    model = body.model
    weight = model.mass * model.gravity[2]
    none = 0.0 * state.force
    e = vector(state.force[1], -state.force[0], 0.0) / weight if gains.attitude else none
    d = vector(state.torque[1], -state.torque[0], 0.0) / weight if gains.cog else none
    # The measured body is the real one turned by e: the real one is the measured one turned back.
    to_cog = model.R_root_C.T @ model.cog_root + d
    to_tip = model.tip_C - d
    R = body.R_WC
    moved = R @ (to_cog - model.R_root_C.T @ model.cog_root - cross(e, to_cog))
    return body._replace(position=body.position + moved), R @ (to_tip - cross(e, to_tip))


def fed_bias(gains: Any, state: Correction, yaw: Any) -> Wrench:
    """The bias that the rotors have to make up: force in W (N), torque in C (N m)."""
    if not gains.feed:
        return Wrench(0.0 * state.force, 0.0 * state.torque)
    return Wrench(rot_z(yaw) @ state.force, state.torque)
