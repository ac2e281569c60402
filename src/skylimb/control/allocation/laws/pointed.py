"""All six directions around vectoring angles that are planned in flight: thrusts and angles give the wrench.

The plan is that of `planned`. Around it thrusts and angles together give force and torque
(`allocation.pointing`), so the body stays level, and a torque has no side force that only a tilt could take
off again. It is for robots whose thrusts alone push far to the side when they turn it, as DRAGON's do.

The target attitude is that of {C}, which the moves turn in the body. So `aim` returns the force along which z
of {C} lies while the body is level.
"""

from __future__ import annotations

from dataclasses import field
from typing import Any, NamedTuple

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.keys import configuration
from skylimb.control.allocation.laws import planned
from skylimb.control.allocation.level_moves import aim_level
from skylimb.control.allocation.pointing import Pointed, Pointing, pointed
from skylimb.control.allocation.rotor_lag import RotorLag, Rotors, allocated, at_rest
from skylimb.control.estimation.body_state import rotor_wrench
from skylimb.control.estimation.records import Signals, Start, Wrench
from skylimb.control.needs import Needs
from skylimb.control.records import NOTHING, Allocated, Demand, LawInput
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, stack

PROVIDES = ("residual",)
REQUIRES = ("estimate.body",)


@configuration
class Gains:
    """Moves around the plan, and how fast rotors follow."""

    pointing: Pointing = field(default_factory=Pointing)
    rotor_lag: RotorLag = field(default_factory=RotorLag)


class State(NamedTuple):
    """What the law remembers.

    Attributes:
        plan: vectoring angles as they are planned.
        rotors: as their lag is modelled.
        pointed: thrusts and moves of the last tick.
        residual: wanted less given wrench of the last tick, W and C.
    """

    plan: planned.Plan
    rotors: Rotors
    pointed: Pointed
    residual: Wrench


def needs(gains: Gains) -> Needs:
    """It takes off with the best angles of the nominal posture, and searches no table."""
    return planned.needs(planned.Gains())


def require(gains: Gains, dt: float) -> None:
    """Raise a `ConfigError` for a control rate below that of the plans."""
    planned.require_rate("pointed", dt)


def initial_state(gains: Gains, start: Start) -> State:
    """Hovering at the angles of the nominal posture, no move made.

    Raises:
        AllocationError: no vectoring angles let it hover there.
        ConfigError: for a robot whose rotors do not turn in enough directions.
    """
    robot = start.robot
    _require_turning_rotors(robot)
    hover = start.hover_thrusts
    still = Pointed(hover, np.zeros(robot.n_vectoring))
    return State(planned.initial_plan(robot), at_rest(hover), still, NOTHING)


def aim(gains: Any, state: State, inputs: LawInput, force: Array) -> Array:
    """The force along which {C} has to point, W, N, (3,), with the body level."""
    angles, nominal = inputs.measurement.joint_angles, planned.angles_of(state.plan, inputs.dt)
    return aim_level(inputs.robot, inputs.estimate.body, angles, nominal, force)


def step(gains: Any, state: State, inputs: LawInput, demand: Demand) -> tuple[State, Allocated, Signals]:
    """Thrusts and vectoring angles for the whole wrench."""
    body, dt = inputs.estimate.body, inputs.dt
    plan = planned.next_plan(inputs.robot, state.plan, demand.joint_angles, dt)
    angles = planned.angles_of(plan, dt)
    R = body.model.R_root_C
    wrench = stack(R @ (body.R_WC.T @ demand.force), R @ demand.torque)
    new, missing = pointed(
        gains.pointing, inputs.robot, state.pointed, inputs.measurement.joint_angles, angles, wrench, dt
    )
    # What the angles give late is no shortage, or integrators would hold whenever an angle moves.
    residual = rotor_wrench(body, missing)
    signals = {
        "allocation_residual_force": residual.force,
        "allocation_residual_torque": residual.torque,
        "vectoring_move": new.move,
        "vectoring_margin": plan.margin,
    }
    end, made = allocated(
        gains.rotor_lag, state.rotors, new.thrusts, inputs, demand.joint_angles, angles + new.move
    )
    return State(plan, end, new, residual), made, signals


def _require_turning_rotors(robot: Robot) -> None:
    if robot.n_vectoring < 2:
        raise ConfigError(
            "allocation.law = 'pointed' turns rotors for a wrench in six directions; those of "
            f"'{robot.name}' turn about {robot.n_vectoring} vectoring joints, so it has to be 'bounded' or "
            "'planned'"
        )
