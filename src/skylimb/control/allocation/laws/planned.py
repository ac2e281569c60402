"""Thrusts as `bounded`, vectoring angles planned in flight: for any posture, without a table.

The angles of a posture come from `planning.vectoring_step`: twenty times a second a few Newton steps from the
angles of before, towards more torque in every direction and a level hover. Between two plans the command goes
evenly from one to the next, so it is a twentieth of a second late. The plan looks at the commanded joint
angles alone, so a rehearsal on the ground gives the same angles as the flight.

What a plan has left is recorded. A flight whose nominal postures leave too little is refused before take-off.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from skylimb.base.errors import ConfigError
from skylimb.base.keys import configuration
from skylimb.control.allocation.laws import bounded
from skylimb.control.estimation.records import Signals, Start, Wrench
from skylimb.control.needs import Needs
from skylimb.control.planning.vectoring import ONLINE
from skylimb.control.planning.vectoring_step import RATE, STEP, first_vectoring, plan_when
from skylimb.control.records import Allocated, Demand, LawInput
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, where

PROVIDES, REQUIRES, OPTIONAL = bounded.PROVIDES, bounded.REQUIRES, bounded.OPTIONAL

_NEVER = 1e9
"""Ticks since a plan where there was none."""


@configuration
class Gains(bounded.ThrustGains):
    """Those of `bounded`; the plan has none, so that a rehearsal needs no controller."""


class Plan(NamedTuple):
    """Where the vectoring angles are on their way between two plans.

    Attributes:
        begin: vectoring angles where the way between two plans begins, rad, (nv,).
        end: where it ends, rad, (nv,).
        ticks: since the last plan.
        margin: of the last plan, N m.
    """

    begin: Array
    end: Array
    ticks: Any
    margin: Any


class State(NamedTuple):
    """What the thrusts' law remembers, and the plan."""

    bounded: bounded.State
    plan: Plan

    @property
    def residual(self) -> Wrench:
        """What the rotors fell short of at the last tick."""
        return self.bounded.residual


def needs(gains: Gains) -> Needs:
    """It takes off with the best angles of the nominal posture, and searches no table."""
    return Needs(vectoring=ONLINE)


def require(gains: Gains, dt: float) -> None:
    """Raise a `ConfigError` for a control rate below that of the plans."""
    require_rate("planned", dt)


def require_rate(law: str, dt: float) -> None:
    """Raise a `ConfigError` that names the law where it is asked less often than it plans.

    Args:
        law: that plans angles in flight.
        dt: control period, s.
    """
    if dt > 1.0 / RATE:
        raise ConfigError(
            f"allocation law '{law}' plans {RATE:g} times a second; a control rate of {1.0 / dt:g} Hz is "
            "too low for it"
        )


def initial_state(gains: Gains, start: Start) -> State:
    """Hovering at the angles of the nominal posture.

    Raises:
        AllocationError: no vectoring angles let it hover there.
    """
    return State(bounded.initial_state(gains, start), initial_plan(start.robot))


def initial_plan(robot: Robot) -> Plan:
    """The best angles of the nominal posture.

    Raises:
        AllocationError: no vectoring angles let it hover there.
    """
    first = first_vectoring(robot)
    return Plan(first.angles, first.angles, _NEVER, first.margin)


def next_plan(robot: Robot, plan: Plan, joint_angles: Array, dt: float) -> Plan:
    """The plan of the next tick: a new one twenty times a second.

    Args:
        robot: the controller's model.
        plan: of the last tick.
        joint_angles: commanded, rad, (nq,).
        dt: control period, s.
    """
    due = plan.ticks >= _period(dt)
    end, margin = plan_when(robot, due, joint_angles, plan.end, STEP, plan.margin)
    begin, ticks = where(due, plan.end, plan.begin), where(due, 0.0, plan.ticks) + 1.0
    return Plan(begin, end, ticks, margin)


def angles_of(plan: Plan, dt: float) -> Array:
    """Vectoring angles of this tick, rad, (nv,)."""
    return plan.begin + (plan.ticks / _period(dt)) * (plan.end - plan.begin)


def _period(dt: float) -> int:
    return round(1.0 / (RATE * dt))


def aim(gains: Any, state: State, inputs: LawInput, force: Array) -> Array:
    """The part of the wanted force that the tilt has to give, W, N."""
    return bounded.aim(gains, state.bounded, inputs, force)


def step(gains: Any, state: State, inputs: LawInput, demand: Demand) -> tuple[State, Allocated, Signals]:
    """Vectoring angles on their way to the last plan, and thrusts within limits and rates."""
    plan = next_plan(inputs.robot, state.plan, demand.joint_angles, inputs.dt)
    demand = demand._replace(vectoring_angles=angles_of(plan, inputs.dt))
    inner, given, signals = bounded.step(gains, state.bounded, inputs, demand)
    return State(inner, plan), given, {**signals, "vectoring_margin": plan.margin}
