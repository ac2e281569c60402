"""Thrusts as `bounded`, vectoring angles planned in flight: for any posture, without a table.

The angles of a posture come from `planning.vectoring_step`: twenty times a second a few Newton steps from the
angles of before, towards more torque in every direction and a level hover. Between two plans the command goes
evenly from one to the next, so it is a twentieth of a second late. The plan looks at the commanded joint
angles alone, so a rehearsal on the ground gives the same angles as the flight.

What a plan has left is recorded. A flight whose nominal postures leave too little is refused before take-off.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from skylimb.control.allocation import bounded
from skylimb.control.needs import Needs
from skylimb.control.records import Allocated, Demand, LawInput
from skylimb.errors import ConfigError
from skylimb.estimation.records import Signals, Start, Wrench
from skylimb.keys import configuration
from skylimb.planning.vectoring import ONLINE
from skylimb.planning.vectoring_step import RATE, STEP, first_vectoring, plan_when
from skylimb.symbolic import Array, where

_NEVER = 1e9
"""Ticks since a plan where there was none."""


@configuration
class Gains(bounded.ThrustGains):
    """Those of `bounded`; the plan has none, so that a rehearsal needs no controller."""


class State(NamedTuple):
    """What the law remembers.

    Attributes:
        bounded: what the thrusts' law remembers.
        begin: vectoring angles where the way between two plans begins, rad, (nv,).
        end: where it ends, rad, (nv,).
        ticks: since the last plan.
        margin: of the last plan, N m.
    """

    bounded: bounded.State
    begin: Array
    end: Array
    ticks: Any
    margin: Any

    @property
    def residual(self) -> Wrench:
        """What the rotors fell short of at the last tick."""
        return self.bounded.residual


def needs(gains: Gains) -> Needs:
    """It takes off with the best angles of the nominal posture, and searches no table."""
    return Needs(vectoring=ONLINE)


def require(gains: Gains, dt: float) -> None:
    """Raise a `ConfigError` for a control rate below that of the plans."""
    if dt > 1.0 / RATE:
        raise ConfigError(
            f"allocation law 'planned' plans {RATE:g} times a second; a control rate of {1.0 / dt:g} Hz is "
            "too low for it"
        )


def initial_state(gains: Gains, start: Start) -> State:
    """Hovering at the angles of the nominal posture.

    Raises:
        AllocationError: no vectoring angles let it hover there.
    """
    first = first_vectoring(start.robot)
    state = bounded.initial_state(gains, start)
    return State(state, first.angles, first.angles, _NEVER, first.margin)


def aim(gains: Any, state: State, inputs: LawInput, force: Array) -> Array:
    """The part of the wanted force that the tilt has to give, W, N."""
    return bounded.aim(gains, state.bounded, inputs, force)


def step(gains: Any, state: State, inputs: LawInput, demand: Demand) -> tuple[State, Allocated, Signals]:
    """Vectoring angles on their way to the last plan, and thrusts within limits and rates."""
    period = round(1.0 / (RATE * inputs.dt))
    due = state.ticks >= period
    end, margin = plan_when(inputs.robot, due, demand.joint_angles, state.end, STEP, state.margin)
    begin, ticks = where(due, state.end, state.begin), where(due, 0.0, state.ticks) + 1.0
    angles = begin + (ticks / period) * (end - begin)
    inner, given, signals = bounded.step(
        gains, state.bounded, inputs, demand._replace(vectoring_angles=angles)
    )
    new = State(inner, begin, end, ticks, margin)
    return new, given, {**signals, "vectoring_margin": margin}
