"""Lift and torque by the thrusts, side force by small moves of the vectoring angles and by the tilt.

The rotors turn by a few degrees at once, where a tilt takes its time (`allocation.lateral`). The side force
that the thrusts make without any move is the leak, and the tilt gives the rest. Beyond the limits the thrusts
are those of the nearest wrench, as in `bounded`: a yaw that the rotors cannot give costs no roll and pitch.
"""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Any, NamedTuple

import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.control.allocation.lateral import Moves, lateral_move
from skylimb.control.allocation.laws import pseudoinverse
from skylimb.control.allocation.laws.bounded import Weights, nearest_thrusts
from skylimb.control.allocation.leak import Leak, follow_leak
from skylimb.control.allocation.rotor_lag import RotorLag, Rotors, allocated, at_rest, known_reaction
from skylimb.control.allocation.thrusts import unlimited
from skylimb.control.estimation.records import Signals, Start
from skylimb.control.needs import Needs
from skylimb.control.records import Allocated, Demand, LawInput
from skylimb.symbolic import Array

PROVIDES = ()
REQUIRES = ("estimate.body",)


@configuration
class Vectoring(Moves, pseudoinverse.Vectoring):
    """Nominal vectoring angles, and the moves around them."""


@configuration
class Gains:
    """How the rotors are used."""

    hold_lift: Annotated[
        bool, Key("", "whether the thrusts for a torque are chosen so that they do not lift")
    ] = True
    weights: Weights = field(default_factory=Weights)
    leak: Leak = field(default_factory=Leak)
    rotor_lag: RotorLag = field(default_factory=RotorLag)
    vectoring: Vectoring = field(default_factory=Vectoring)


class State(NamedTuple):
    """Known leak, W, N, (3,), rotors, and move of the vectoring angles, rad, (nv,)."""

    leak: Array
    rotors: Rotors
    move: Array


def needs(gains: Gains) -> Needs:
    """The vectoring angles to take off with, and how far they move."""
    return Needs(vectoring=gains.vectoring.purpose, moves=gains.vectoring.limit)


def initial_state(gains: Gains, start: Start) -> State:
    """Hovering; no leak known, no move made."""
    return State(np.zeros(3), at_rest(start.hover_thrusts), np.zeros(start.robot.n_vectoring))


aim = pseudoinverse.aim


def step(gains: Any, state: State, inputs: LawInput, demand: Demand) -> tuple[State, Allocated, Signals]:
    """Thrusts for lift and torque, and vectoring angles for the side force."""
    body, limits, dt = inputs.estimate.body, inputs.robot.thrust_limits(), inputs.dt
    reaction = known_reaction(gains.rotor_lag, state.rotors, inputs)
    wanted = unlimited(body, demand.force, demand.torque, gains.hold_lift, reaction)
    thrusts = nearest_thrusts(gains.weights, body.model.allocation_C, wanted.total, limits)
    move, side = lateral_move(gains.vectoring, state.move, inputs, demand)
    leak = follow_leak(gains.leak, state.leak, body.R_WC @ side, dt)
    angles = demand.vectoring_angles + move
    angles = angles + (gains.vectoring.lead - 1.0) * (angles - inputs.measurement.vectoring_angles)
    end, given = allocated(gains.rotor_lag, state.rotors, thrusts, inputs, demand.joint_angles, angles)
    return State(leak, end, move), given, {}
