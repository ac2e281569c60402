"""The paper's allocation: lift and torque by the thrusts, side force by the tilt of the whole robot.

What the paper does not have is off unless a preset switches it on: compensation of the leak and of the
rotors' lag, thrusts for a torque that do not lift, vectoring angles for contact.
"""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.control.allocation.leak import TorqueLeak, follow_leak, side_force, without_leak
from skylimb.control.allocation.rotor_lag import RotorLag, Rotors, allocated, at_rest, known_reaction
from skylimb.control.allocation.thrusts import allocate
from skylimb.control.estimation.records import Signals, Start
from skylimb.control.needs import Needs
from skylimb.control.records import Allocated, Demand, LawInput
from skylimb.symbolic import Array

PROVIDES = ()
REQUIRES = ("estimate.body",)
OPTIONAL = {"estimate.wrench": "leak.steady", "estimate.bias": ""}


@configuration
class Vectoring:
    """The nominal vectoring angles."""

    purpose: Annotated[
        Literal["torque", "contact"],
        Key("", "what the angles over the posture were chosen for; the paper's for torque"),
    ] = "torque"


@configuration
class Gains:
    """What is done besides the paper's allocation."""

    hold_lift: Annotated[
        bool, Key("", "whether the thrusts for a torque are chosen so that they do not lift")
    ] = False
    leak: TorqueLeak = field(default_factory=TorqueLeak)
    rotor_lag: RotorLag = field(default_factory=RotorLag)
    vectoring: Vectoring = field(default_factory=Vectoring)


class State(NamedTuple):
    """Known leak, W, N, (3,), and rotors."""

    leak: Array
    rotors: Rotors


def needs(gains: Gains) -> Needs:
    """The vectoring angles to take off with."""
    return Needs(vectoring=gains.vectoring.purpose)


def initial_state(gains: Gains, start: Start) -> State:
    """Hovering; no leak known."""
    return State(np.zeros(3), at_rest(start.hover_thrusts))


def aim(gains: Any, state: State, inputs: LawInput, force: Array) -> Array:
    """The part of the wanted force that the tilt has to give, W, N: all that does not leak anyway."""
    return without_leak(gains.leak, state.leak, force)


def step(gains: Any, state: State, inputs: LawInput, demand: Demand) -> tuple[State, Allocated, Signals]:
    """Thrusts for the aimed force and the torque; the vectoring angles stay nominal."""
    body, limits, dt = inputs.estimate.body, inputs.robot.thrust_limits(), inputs.dt
    reaction = known_reaction(gains.rotor_lag, state.rotors, inputs)
    thrusts = allocate(body, demand.aimed, demand.torque, limits, gains.hold_lift, reaction)
    leak = follow_leak(gains.leak, state.leak, side_force(gains.leak, inputs, thrusts), dt)
    end, given = allocated(
        gains.rotor_lag, state.rotors, thrusts.total, inputs, demand.joint_angles, demand.vectoring_angles
    )
    return State(leak, end), given, {}
