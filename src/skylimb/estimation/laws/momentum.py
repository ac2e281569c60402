"""The paper's estimation: body state, momentum observer and filtered contact force; and a tare.

    measurement -> angle rates -> body state -> observer -> tare -> contact force

The paper prints no tare. One degree of attitude error reads as 0.6 N, so it is on unless it is switched off.
"""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Any, NamedTuple

import numpy as np

from skylimb.estimation.body_state import (
    AngleRateFilter,
    AngleRateState,
    angle_rates,
    body_state,
    initial_angle_rate_state,
    measured_angles,
)
from skylimb.estimation.force_filter import ForceFilter, filter_force
from skylimb.estimation.momentum_observer import (
    ObserverGains,
    ObserverState,
    initial_observer_state,
    known_wrench,
    observe,
)
from skylimb.estimation.records import Estimate, Sensed, Signals, Start, Wrench
from skylimb.estimation.tare import TareState, initial_tare_state, tare
from skylimb.keys import Key, configuration
from skylimb.spatial import dot, rpy_from_rotation


@configuration
class Gains:
    """Gains of the parts."""

    angle_rates: AngleRateFilter = field(default_factory=AngleRateFilter)
    observer: ObserverGains = field(default_factory=ObserverGains)
    force_filter: ForceFilter = field(default_factory=ForceFilter)
    tare: Annotated[bool, Key("", "whether the observer's bias in free flight is taken off")] = True


class State(NamedTuple):
    """States of the parts, and the filtered contact force, N."""

    angle_rates: AngleRateState
    observer: ObserverState
    tare: TareState
    contact_force: Any


def initial_state(gains: Gains, start: Start) -> State:
    """Nothing is known of any wrench."""
    return State(initial_angle_rate_state(start.robot), initial_observer_state(), initial_tare_state(), 0.0)


def step(gains: Any, state: State, sensed: Sensed) -> tuple[State, Estimate, Signals]:
    """The estimate of this tick."""
    robot, measurement, reference, dt = sensed
    rates, angle_rate = angle_rates(gains.angle_rates, state.angle_rates, measured_angles(measurement), dt)
    body = body_state(robot, measurement, angle_rate)
    observer, raw = observe(gains.observer, state.observer, body, dt)
    yaw = rpy_from_rotation(body.R_WC)[2]
    bias, tared = tare(state.tare, raw, yaw, reference.tare)
    wrench = tared if gains.tare else raw
    pushed = dot(wrench.force, reference.contact_axis)
    contact_force = filter_force(gains.force_filter, state.contact_force, pushed, dt)
    arm = body.R_WC @ body.model.tip_C
    nothing = Wrench(np.zeros(3), np.zeros(3))
    estimate = Estimate(body, wrench, raw, contact_force, arm, nothing)
    return State(rates, observer, bias, contact_force), estimate, {}


def commanded(gains: Any, state: State, estimate: Estimate, rotors: Wrench, dt: float) -> State:
    """The state that knows which wrench the rotors make until the next tick."""
    known = known_wrench(estimate.body, rotors)
    return state._replace(
        observer=state.observer._replace(known_force=known.force, known_torque=known.torque)
    )
