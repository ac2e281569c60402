"""The paper's allocation where the rotors can give it, else the nearest wrench that they can.

The paper allocates as if thrusts had no limits and cuts off what is beyond them (`allocation.pseudoinverse`).
What is cut off is a wrench in a direction that nobody chose: a rotor at its limit takes roll, pitch and lift
along. Here the thrusts are those within limits and rates whose wrench is nearest to the wanted one,

    minimise  |W Q (lambda - lambda_wanted)|^2,    lower <= lambda <= upper,

with lambda_wanted of eq:thrust without limits, Q of eq:allocation for wrench and W the weights of its six
rows. More rotors than rows of Q leave a choice: the thrusts near the paper's. Thrusts of the paper within the
limits come back as they are, to the last bit.

The side force that counts is that of lambda_wanted, so the leak is not chased: it is what it would be without
limits, and what is missing of it is part of the residual.

The residual, wanted less given wrench, is recorded. The estimation is told the wrench that is really given,
and integrators hold where the rotors fall short (`LawInput.residual`).
"""

from __future__ import annotations

import itertools
from dataclasses import field
from typing import Annotated, Any, NamedTuple

import numpy as np

from skylimb.control.allocation import pseudoinverse
from skylimb.control.box_least_squares import nearest_in_box
from skylimb.control.leak import TorqueLeak, follow_leak, side_force, without_leak
from skylimb.control.needs import Needs
from skylimb.control.records import Allocated, Command, Demand, LawInput
from skylimb.control.rotor_lag import RotorLag, lead_thrusts
from skylimb.control.thrusts import Limits, rotor_wrench, thrust_limits, unlimited
from skylimb.estimation.records import Signals, Start, Wrench
from skylimb.keys import Key, configuration
from skylimb.symbolic import Array, clip, diagonal, is_symbolic, vector


@configuration
class Weights:
    """What a unit of residual counts, in {C}; only their ratios matter.

    Where the rotors cannot give all of the wrench, the rows with small weights give way: an error counts by
    the square of its weight. Roll and pitch keep the robot in the air, lift keeps its height, side force its
    place. A yaw that comes late does no harm.
    """

    roll_pitch: Annotated[
        float, Key("1/(N m)", "weight of the torques that tilt the robot", low=1e-3, high=1e3)
    ] = 10.0
    lift: Annotated[float, Key("1/N", "weight of the force along the thrust axis", low=1e-3, high=1e3)] = 3.0
    sideways: Annotated[float, Key("1/N", "weight of the forces across it", low=1e-3, high=1e3)] = 1.0
    yaw: Annotated[
        float, Key("1/(N m)", "weight of the torque about the thrust axis", low=1e-3, high=1e3)
    ] = 0.3


@configuration
class Gains:
    """Weights and rates, and what the paper's allocation has besides."""

    hold_lift: Annotated[
        bool, Key("", "whether the thrusts for a torque are chosen so that they do not lift")
    ] = False
    rate: Annotated[
        float,
        Key(
            "N/s", "greatest rate of a thrust before its lag is led; the default is none", above=0.0, high=1e6
        ),
    ] = 1e6
    weights: Weights = field(default_factory=Weights)
    leak: TorqueLeak = field(default_factory=TorqueLeak)
    rotor_lag: RotorLag = field(default_factory=RotorLag)
    vectoring: pseudoinverse.Vectoring = field(default_factory=pseudoinverse.Vectoring)


class State(NamedTuple):
    """What the law remembers.

    Attributes:
        leak: known one, W, N, (3,).
        thrusts: modelled, N, (n,).
        allocated: thrusts of the last tick before their lag was led, N, (n,).
        residual: wanted less given wrench of the last tick, W and C.
    """

    leak: Array
    thrusts: Array
    allocated: Array
    residual: Wrench


def needs(gains: Gains) -> Needs:
    """The vectoring angles to take off with."""
    return Needs(vectoring=gains.vectoring.purpose)


def initial_state(gains: Gains, start: Start) -> State:
    """Hovering; no leak known, nothing missing."""
    return State(np.zeros(3), start.hover_thrusts, start.hover_thrusts, Wrench(np.zeros(3), np.zeros(3)))


def aim(gains: Any, state: State, inputs: LawInput, force: Array) -> Array:
    """The part of the wanted force that the tilt has to give, W, N: all that does not leak anyway."""
    return without_leak(gains.leak, state.leak, force)


def step(gains: Any, state: State, inputs: LawInput, demand: Demand) -> tuple[State, Allocated, Signals]:
    """Thrusts within limits and rates for the aimed force and the torque; vectoring angles stay nominal."""
    body, dt = inputs.estimate.body, inputs.dt
    limits = thrust_limits(inputs.robot)
    wanted = unlimited(body, demand.aimed, demand.torque, gains.hold_lift)
    given = nearest_thrusts(
        gains.weights,
        body.model.allocation_C,
        wanted.total,
        reachable(limits, state.allocated, gains.rate * dt),
    )
    led = lead_thrusts(gains.rotor_lag, state.thrusts, given, limits, dt)
    leak = follow_leak(gains.leak, state.leak, side_force(gains.leak, inputs, wanted), dt)
    missing = rotor_wrench(body, wanted.total - given)
    signals = {"allocation_residual_force": missing.force, "allocation_residual_torque": missing.torque}
    command = Command(led.command, demand.joint_angles, demand.vectoring_angles)
    new = State(leak, led.end, given, missing)
    return new, Allocated(command, rotor_wrench(body, led.mean)), signals


def reachable(limits: Limits, before: Array, change: Any) -> Limits:
    """Least and greatest thrust of this tick, N, (n,) each: the rotors' own, at most `change` away.

    Args:
        limits: of the rotors, N, (n,) each.
        before: thrusts of the last tick, within them, N, (n,).
        change: greatest one in a tick, N.
    """
    return clip(before - change, *limits), clip(before + change, *limits)


def nearest_thrusts(weights: Any, allocation: Array, wanted: Array, limits: Limits) -> Array:
    """The thrusts within the limits whose wrench is nearest to that of the wanted ones, N, (n,).

    Args:
        weights: a `Weights`.
        allocation: Q of eq:allocation for wrench in {C}, (6, n).
        wanted: thrusts without limits, N, (n,).
        limits: least and greatest thrust, N, (n,) each.
    """
    w = (weights.sideways,) * 2, (weights.lift,), (weights.roll_pitch,) * 2, (weights.yaw,)
    rows = diagonal(vector(*itertools.chain(*w))) @ allocation
    thrusts, _ = nearest_in_box(*allocation.shape)(rows, wanted, *limits)
    return thrusts if is_symbolic(allocation, wanted) else thrusts.full().ravel()
