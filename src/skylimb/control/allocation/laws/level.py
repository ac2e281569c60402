"""Force and torque in all six directions with the body level: thrusts and vectoring angles together.

Lift and torque come from the thrusts at the measured angles, at once and within limits as in `bounded`. The
side force comes from the vectoring angles (`allocation.level_moves`), as fast as their servos turn. So four
rotors that turn give six directions, and a sideways push leaves the body level.

The target attitude is that of {C}, which the vectoring angles turn in the body. So `aim` returns the force
along which z of {C} lies while the body is level, and adds what the angles cannot give within their limits:
that part the tilt has to give, low-passed.
"""

from __future__ import annotations

import math
from dataclasses import field
from typing import Annotated, Any, NamedTuple

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.keys import Key, configuration
from skylimb.control.allocation.laws import pseudoinverse
from skylimb.control.allocation.laws.bounded import Weights, nearest_thrusts, reachable
from skylimb.control.allocation.level_moves import LevelMoves, aim_level, level_move
from skylimb.control.allocation.rotor_lag import RotorLag, Rotors, allocated, at_rest, known_reaction
from skylimb.control.allocation.thrusts import unlimited
from skylimb.control.estimation.body_state import rotor_wrench
from skylimb.control.estimation.records import Signals, Start, Wrench
from skylimb.control.needs import Needs
from skylimb.control.records import NOTHING, Allocated, Demand, LawInput
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, low_pass, vector

PROVIDES = ("residual",)
REQUIRES = ("estimate.body",)


@configuration
class Vectoring(LevelMoves, pseudoinverse.Vectoring):
    """Nominal vectoring angles, and the moves around them."""


@configuration
class Gains:
    """How rotors and vectoring angles share the wrench."""

    weights: Weights = field(default_factory=Weights)
    rate: Annotated[
        float,
        Key(
            "N/s", "greatest rate of a thrust before its lag is led; the default is none", above=0.0, high=1e6
        ),
    ] = 1e6
    tilt_cutoff: Annotated[
        float,
        Key("Hz", "cut-off of the low pass on the force that is left to the tilt", above=0.0, high=100.0),
    ] = 0.5
    rotor_lag: RotorLag = field(default_factory=RotorLag)
    vectoring: Vectoring = field(default_factory=Vectoring)


class State(NamedTuple):
    """What the law remembers.

    Attributes:
        rotors: as their lag is modelled.
        allocated: thrusts of the last tick before their lag was led, N, (n,).
        posed: vectoring angles of the last tick's posture less those of the reference's, rad, (nv,).
        move: of the vectoring angles from the posture's, rad, (nv,).
        pull: toward the thrusts of the hover, rad, (nv,).
        short: side force that the angles fall short of, low-passed, W, N, (3,).
        residual: wanted less given wrench of the last tick, W and C.
    """

    rotors: Rotors
    allocated: Array
    posed: Array
    move: Array
    pull: Array
    short: Array
    residual: Wrench


def needs(gains: Gains) -> Needs:
    """The vectoring angles to take off with, and how far they move."""
    return Needs(vectoring=gains.vectoring.purpose, moves=gains.vectoring.limit)


def initial_state(gains: Gains, start: Start) -> State:
    """Hovering at the first posture; no move made, nothing missing.

    Raises:
        ConfigError: for a robot whose vectoring angles give no side force in two directions.
    """
    _require_turning_rotors(start.robot)
    none = np.zeros(start.robot.n_vectoring)
    return State(at_rest(start.hover_thrusts), start.hover_thrusts, none, none, none, np.zeros(3), NOTHING)


def aim(gains: Any, state: State, inputs: LawInput, force: Array) -> Array:
    """The force along which {C} has to point, W, N, (3,): with the body level, plus what the angles miss."""
    body = inputs.estimate.body
    nominal = inputs.reference.vectoring_angles + state.posed
    levelled = aim_level(inputs.robot, body, inputs.measurement.joint_angles, nominal, force)
    return levelled + vector(state.short[0], state.short[1], 0.0)


def step(gains: Any, state: State, inputs: LawInput, demand: Demand) -> tuple[State, Allocated, Signals]:
    """Thrusts for lift and torque, vectoring angles for the side force."""
    body, dt = inputs.estimate.body, inputs.dt
    limits = inputs.robot.thrust_limits()
    reaction = known_reaction(gains.rotor_lag, state.rotors, inputs)
    wanted = unlimited(body, demand.force, demand.torque, hold_lift=True, reaction=reaction)
    within = reachable(limits, state.allocated, gains.rate * dt)
    given = nearest_thrusts(gains.weights, body.model.allocation_C, wanted.total, within)
    moved = level_move(gains.vectoring, state.move, state.pull, inputs, demand)
    short = low_pass(state.short, moved.short, 2.0 * math.pi * gains.tilt_cutoff, dt)
    missing = rotor_wrench(body, wanted.total - given)
    residual = Wrench(missing.force + moved.short, missing.torque)
    angles = demand.vectoring_angles + moved.move
    angles = angles + (gains.vectoring.lead - 1.0) * (angles - inputs.measurement.vectoring_angles)
    signals = {
        "allocation_residual_force": residual.force,
        "allocation_residual_torque": residual.torque,
        "vectoring_move": moved.move,
    }
    posed = demand.vectoring_angles - inputs.reference.vectoring_angles
    end, made = allocated(gains.rotor_lag, state.rotors, given, inputs, demand.joint_angles, angles)
    return State(end, given, posed, moved.move, moved.pull, short, residual), made, signals


def _require_turning_rotors(robot: Robot) -> None:
    if robot.n_vectoring < 2:
        raise ConfigError(
            f"allocation.law = 'level' turns rotors for a side force; those of '{robot.name}' turn about "
            f"{robot.n_vectoring} vectoring joints, so it has to be 'bounded'"
        )
