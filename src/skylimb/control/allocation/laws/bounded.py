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

A robot whose rotors give wrenches in all six directions need not tilt for a side force (`side_force =
"rotors"`). Its lambda_wanted is then the least-norm one of all six rows, Q^T (Q Q^T)^-1 w, and the tilt gives
only what the rotors fall short of, low-passed.

The residual, wanted less given wrench, is recorded. The estimation gets the wrench that is really given,
and integrators hold where the rotors fall short (`LawInput.residual`).
"""

from __future__ import annotations

import itertools
from dataclasses import field
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.keys import Key, configuration
from skylimb.control.allocation.laws import pseudoinverse
from skylimb.control.allocation.leak import TorqueLeak, follow_leak, side_force, without_leak
from skylimb.control.allocation.rotor_lag import RotorLag, Rotors, allocated, at_rest, known_reaction
from skylimb.control.allocation.rotor_reaction import Reaction
from skylimb.control.allocation.thrusts import Limits, Thrusts, unlimited
from skylimb.control.box_least_squares import nearest_in_box
from skylimb.control.estimation.body_state import rotor_wrench
from skylimb.control.estimation.records import BodyState, Signals, Start, Wrench
from skylimb.control.needs import Needs
from skylimb.control.records import NOTHING, Allocated, Demand, LawInput
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, clip, diagonal, is_symbolic, solve_positive, stack, vector

PROVIDES = ("residual",)
REQUIRES = ("estimate.body",)
OPTIONAL = {"estimate.wrench": "leak.steady", "estimate.bias": ""}


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
class ThrustGains:
    """How thrusts are made of force and torque, whatever the vectoring angles."""

    hold_lift: Annotated[
        bool, Key("", "whether the thrusts for a torque are chosen so that they do not lift")
    ] = False
    side_force: Annotated[
        Literal["tilt", "rotors"],
        Key("", "what gives it: the tilt of the robot, or rotors that give wrenches in all six directions"),
    ] = "tilt"
    rate: Annotated[
        float,
        Key(
            "N/s", "greatest rate of a thrust before its lag is led; the default is none", above=0.0, high=1e6
        ),
    ] = 1e6
    weights: Weights = field(default_factory=Weights)
    leak: TorqueLeak = field(default_factory=TorqueLeak)
    rotor_lag: RotorLag = field(default_factory=RotorLag)


@configuration
class Gains(ThrustGains):
    """Weights and rates, and what the paper's allocation has besides."""

    vectoring: pseudoinverse.Vectoring = field(default_factory=pseudoinverse.Vectoring)


class State(NamedTuple):
    """What the law remembers.

    Attributes:
        leak: known one, W, N, (3,); where the rotors give the side force, what they fall short of.
        rotors: as their lag is modelled.
        allocated: thrusts of the last tick before their lag was led, N, (n,).
        residual: wanted less given wrench of the last tick, W and C.
    """

    leak: Array
    rotors: Rotors
    allocated: Array
    residual: Wrench


def needs(gains: Gains) -> Needs:
    """The vectoring angles to take off with."""
    return Needs(vectoring=gains.vectoring.purpose)


def initial_state(gains: ThrustGains, start: Start) -> State:
    """Hovering; no leak known, nothing missing.

    Raises:
        ConfigError: for side force by rotors that do not give wrenches in all six directions.
    """
    if gains.side_force == "rotors":
        _require_all_directions(start.robot)
    return State(
        np.zeros(3),
        at_rest(start.hover_thrusts),
        start.hover_thrusts,
        NOTHING,
    )


def aim(gains: Any, state: State, inputs: LawInput, force: Array) -> Array:
    """The part of the wanted force that the tilt has to give, W, N: all that does not leak anyway."""
    if gains.side_force == "rotors":
        return vector(state.leak[0], state.leak[1], force[2])
    return without_leak(gains.leak, state.leak, force)


def step(gains: Any, state: State, inputs: LawInput, demand: Demand) -> tuple[State, Allocated, Signals]:
    """Thrusts within limits and rates for the aimed force and the torque; vectoring angles stay nominal."""
    body, dt = inputs.estimate.body, inputs.dt
    limits = inputs.robot.thrust_limits()
    level = gains.side_force == "rotors"
    reaction = known_reaction(gains.rotor_lag, state.rotors, inputs)
    wanted = (
        whole_wrench(body, demand.force, demand.torque, reaction)
        if level
        else unlimited(body, demand.aimed, demand.torque, gains.hold_lift, reaction)
    )
    given = nearest_thrusts(
        gains.weights,
        body.model.allocation_C,
        wanted.total,
        reachable(limits, state.allocated, gains.rate * dt),
    )
    missing = rotor_wrench(body, wanted.total - given)
    side = missing.force if level else side_force(gains.leak, inputs, wanted)
    leak = follow_leak(gains.leak, state.leak, side, dt)
    signals = {"allocation_residual_force": missing.force, "allocation_residual_torque": missing.torque}
    end, made = allocated(
        gains.rotor_lag, state.rotors, given, inputs, demand.joint_angles, demand.vectoring_angles
    )
    return State(leak, end, given, missing), made, signals


def reachable(limits: Limits, before: Array, change: Any) -> Limits:
    """Least and greatest thrust of this tick, N, (n,) each: the rotors' own, at most `change` away.

    Args:
        limits: of the rotors, N, (n,) each.
        before: thrusts of the last tick, within them, N, (n,).
        change: greatest one in a tick, N.
    """
    return clip(before - change, *limits), clip(before + change, *limits)


def whole_wrench(body: BodyState, force: Array, torque: Array, reaction: Reaction | None = None) -> Thrusts:
    """The least thrusts for a force in W, N, and a torque in C, N m, as if rotors had no limits.

    Args:
        body: attitude, and an allocation matrix of rank six.
        force: (3,).
        torque: (3,).
        reaction: of the rotors, where it is known.
    """
    Q = body.model.allocation_C
    wrench = stack(body.R_WC.T @ force, torque)
    if reaction is not None:
        Q = Q + reaction.matrix
        wrench = wrench + reaction.matrix @ reaction.thrusts
    total = Q.T @ solve_positive(Q @ Q.T, wrench)
    return Thrusts(total, total - Q.T @ solve_positive(Q @ Q.T, stack(wrench[0:3], 0.0, 0.0, 0.0)))


def _require_all_directions(robot: Robot) -> None:
    Q = robot.wrench_function(robot.nominal_posture(), robot.description.vectoring_start).full()
    rank = int(np.linalg.matrix_rank(Q, tol=1e-3 * np.linalg.norm(Q, 2)))
    if rank < 6:
        raise ConfigError(
            f"allocation.side_force = 'rotors' needs rotors that give wrenches in all six directions; those "
            f"of '{robot.name}' give {rank}, so it has to be 'tilt'"
        )


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
    return thrusts if is_symbolic(allocation, wanted, *limits) else thrusts.full().ravel()
