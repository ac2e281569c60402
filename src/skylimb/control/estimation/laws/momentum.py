"""The paper's estimation: body state, momentum observer and filtered contact force; and a tare.

    measurement -> angle rates -> body state -> smoothing -> observer -> tare -> contact force

The paper smooths nothing and prints no tare. One degree of attitude error reads as 0.6 N, so the tare is on
unless it is switched off.
"""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Any, NamedTuple

from skylimb.base.keys import Key, configuration
from skylimb.control.estimation.body_state import (
    AngleRateFilter,
    AngleRateState,
    initial_angle_rate_state,
    see_body,
)
from skylimb.control.estimation.estimate import PushState, estimate_of
from skylimb.control.estimation.force_filter import ForceFilter
from skylimb.control.estimation.inertial import MEMORY, Inertial
from skylimb.control.estimation.momentum_observer import (
    ObserverGains,
    ObserverState,
    known_wrench,
    observe,
)
from skylimb.control.estimation.records import Estimate, Sensed, Signals, Start, Wrench
from skylimb.control.estimation.smoothing import Smoothed, Smoothing, smoothed_body
from skylimb.control.needs import Needs

PROVIDES = ("estimate.body", "estimate.wrench", "estimate.raw", "estimate.contact_force", "estimate.arm")


@configuration
class Gains:
    """Gains of the parts."""

    angle_rates: AngleRateFilter = field(default_factory=AngleRateFilter)
    smoothing: Smoothing = field(default_factory=Smoothing)
    observer: ObserverGains = field(default_factory=ObserverGains)
    force_filter: ForceFilter = field(default_factory=ForceFilter)
    tare: Annotated[bool, Key("", "whether the observer's bias in free flight is taken off")] = True


class State(NamedTuple):
    """States of the parts."""

    angle_rates: AngleRateState
    smoothed: Smoothed | tuple[()]
    observer: ObserverState
    push: PushState


def needs(gains: Gains) -> Needs:
    """An IMU, where it says the motion, and frames that are not older than its memory then."""
    return Needs(imu=True, memory=MEMORY) if gains.smoothing.imu else Needs()


def initial_state(gains: Gains, start: Start) -> State:
    """Nothing is known of any wrench."""
    kept = Smoothed(inertial=Inertial() if gains.smoothing.imu else ()) if gains.smoothing.on else ()
    return State(initial_angle_rate_state(start.robot), kept, ObserverState(), PushState())


def step(gains: Any, state: State, sensed: Sensed) -> tuple[State, Estimate, Signals]:
    """The estimate of this tick."""
    rates, body = see_body(gains.angle_rates, state.angle_rates, sensed)
    kept, body, told = smoothed_body(gains.smoothing, state, body, rates, sensed)
    observer, raw = observe(gains.observer, state.observer, body, sensed.dt)
    push, estimate = estimate_of(gains, state.push, body, raw, sensed)
    return State(rates, kept, observer, push), estimate, told


def commanded(gains: Any, state: State, estimate: Estimate, rotors: Wrench, dt: float) -> State:
    """The state that knows which wrench the rotors make until the next tick."""
    known = known_wrench(estimate.body, rotors)
    return state._replace(
        observer=state.observer._replace(known_force=known.force, known_torque=known.torque)
    )
