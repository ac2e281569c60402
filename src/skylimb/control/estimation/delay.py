"""Latency, made up for by a model.

A measurement shows the robot as it was some time ago. What happened since is known but for the disturbances.
So the known wrench of every tick is kept in a short history, from which

- the momentum observer gets the wrench that acted when the measured motion was made, and
- position, velocity, attitude and angular velocity are carried forward to now (a Smith predictor):

      v(t) = v(t - L) + 1/m sum_i w_i (u_i + f_ext),
      p(t) = p(t - L) + L v(t - L) + 1/m sum_i w_i s_i (u_i + f_ext)

  with u_i the known force of a past tick, w_i how much of that tick lies within the latency L (s) and s_i the
  time since its middle; attitude and angular velocity alike.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.keys import Key, configuration
from skylimb.base.rotations import small_rotation
from skylimb.control.estimation.records import BodyState, Wrench
from skylimb.symbolic import Array, between, clip, right_inverse, stack

DEPTH = 26
"""Ticks of history; at 200 Hz latencies up to 125 ms can be predicted."""


@configuration
class Delay:
    """What is assumed about the latency."""

    latency: Annotated[float, Key("s", "assumed age of a measurement", low=0.0, high=0.2)] = 0.02


class DelayState(NamedTuple):
    """The known wrench of the last ticks, newest first.

    Each entry is (6,): rotor force less weight in W (N), rotor torque less gyroscopic in C (N m). Without
    arguments it is that of a robot that has been hovering for as long as the history goes back.
    """

    wrenches: tuple[Array, ...] = (np.zeros(6),) * DEPTH


def require_history(key: str, latency: float, dt: float) -> None:
    """Raise a `ConfigError` unless the history, in ticks of `dt` (s), reaches back to a latency.

    Args:
        key: under which it is said.
        latency: that is assumed, s.
        dt: control period, s.
    """
    longest = (DEPTH - 1) * dt
    if latency > longest + 1e-9:
        raise ConfigError(
            f"{key} = {latency:g} s needs a longer history than {DEPTH} ticks of {dt:g} s: at most "
            f"{longest:g} s, or a lower controller_rate"
        )


def remember(state: DelayState, known: Wrench) -> DelayState:
    """The history with the known wrench of the tick to come."""
    return DelayState((stack(known.force, known.torque), *state.wrenches[:-1]))


def shifted(state: DelayState, more: Array) -> DelayState:
    """The history, each wrench of it greater by `more`, (6,)."""
    return DelayState(tuple(wrench + more for wrench in state.wrenches))


def delayed_wrench(latency: Any, state: DelayState, dt: float) -> Wrench:
    """Known wrench that acted over the last tick whose end the next measurement shows."""
    ticks = clip(latency / dt, 0.0, DEPTH - 1.0)
    known = between(state.wrenches, ticks)
    return Wrench(known[0:3], known[3:6])


def predict(gains: Any, state: DelayState, body: BodyState, external: Wrench, dt: float) -> BodyState:
    """The body's state now, from the one that was measured `latency` ago.

    Args:
        gains: a `Delay`.
        state: of the last tick; its newest wrench acted until now.
        body: as measured.
        external: the observer's estimate, with its bias: what the model does not know acts on.
        dt: control period, s.
    """
    ticks = gains.latency / dt
    impulse, moment = 0.0 * state.wrenches[0], 0.0 * state.wrenches[0]
    for index, wrench in enumerate(state.wrenches):
        share = clip(ticks - index, 0.0, 1.0) * dt
        impulse = impulse + share * wrench
        moment = moment + share * (index * dt + 0.5 * share) * wrench
    mass, inertia = body.model.mass, body.model.inertia_C
    latency = gains.latency
    push = (impulse[0:3] + latency * external.force) / mass
    shift = (moment[0:3] + 0.5 * latency**2 * external.force) / mass
    inverse = right_inverse(inertia)
    spin = inverse @ (impulse[3:6] + latency * external.torque)
    angle = inverse @ (moment[3:6] + 0.5 * latency**2 * external.torque)
    return body._replace(
        position=body.position + latency * body.velocity + shift,
        velocity=body.velocity + push,
        R_WC=body.R_WC @ small_rotation(latency * body.angular_velocity + angle),
        angular_velocity=body.angular_velocity + spin,
    )
