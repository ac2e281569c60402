"""An extended-state observer in the estimation slot, in place of the paper's momentum observer.

    skylimb run --controller examples/laws/extended_state.toml

It carries momentum h and the external wrench d along a model, and corrects both by the error of h,

    h <- h + (u + d) dt,    e = h_measured - h,    h <- h + (1 - a^2) e,    d <- d + (1 - a)^2 e / dt,

with u the known wrench. Both poles are a = exp(-bandwidth dt), so that it smooths more than a low pass.
"""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from skylimb.control.estimation.body_state import AngleRateFilter, initial_angle_rate_state, see_body
from skylimb.control.estimation.estimate import PushState, estimate_of
from skylimb.control.estimation.force_filter import ForceFilter
from skylimb.control.estimation.momentum_observer import known_wrench
from skylimb.control.estimation.records import Wrench
from skylimb.symbolic import exp, stack


@dataclass(frozen=True)
class Gains:
    bandwidth: float = 6.0  # 1/s
    tare: bool = True
    angle_rates: AngleRateFilter = field(default_factory=AngleRateFilter)
    force_filter: ForceFilter = field(default_factory=ForceFilter)


class State(NamedTuple):
    angle_rates: Any
    push: Any
    h: Any  # kg m/s in W, kg m^2/s in C
    d: Any  # N in W, N m in C
    u: Any  # as d
    started: Any


def initial_state(gains, start):
    z6 = np.zeros(6)
    return State(initial_angle_rate_state(start.robot), PushState(), z6, z6, z6, 0.0)


def step(gains, state, sensed):
    rates, body = see_body(gains.angle_rates, state.angle_rates, sensed)
    measured = stack(body.model.mass * body.velocity, body.model.inertia_C @ body.angular_velocity)
    a, dt = exp(-gains.bandwidth * sensed.dt), sensed.dt
    h = state.h + (state.u + state.d) * dt
    error = (measured - h) * state.started  # the first tick has no past
    d = state.d + (1.0 - a) ** 2 / dt * error
    push, estimate = estimate_of(gains, state.push, body, Wrench(d[0:3], d[3:6]), sensed)
    return State(rates, push, measured - a**2 * error, d, state.u, 1.0), estimate, {}


def commanded(gains, state, estimate, rotors, dt):
    u = known_wrench(estimate.body, rotors)
    return state._replace(u=stack(u.force, u.torque))
