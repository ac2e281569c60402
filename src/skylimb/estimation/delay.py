"""Latency and rotor lag compensated by a model.

A measurement shows the robot as it was some time ago. What happened since is known but for the disturbances:
the thrusts that were commanded, through the rotors' first-order lag. So the wrench of every tick is kept in a
short history, from which

- the momentum observer gets the wrench that acted when the measured motion was made, and
- position, velocity, attitude and angular velocity are carried forward to now (a Smith predictor):

      v(t) = v(t - L) + 1/m sum_i w_i (u_i + f_ext),
      p(t) = p(t - L) + L v(t - L) + 1/m sum_i w_i s_i (u_i + f_ext)

  with u_i the known force of a past tick, w_i how much of that tick lies within the latency L (s) and s_i the
  time since its middle; attitude and angular velocity alike.

The lag of the rotors is shortened by a lead: lambda_cmd = lambda + lead (lambda_des - lambda), with lambda
the modelled thrust, makes the thrust follow its wish `lead` times faster, at most as fast as it is there
within a tick.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from skylimb.config import require_range
from skylimb.errors import ConfigError
from skylimb.estimation.momentum_observer import GRAVITY
from skylimb.estimation.records import BodyState, Wrench
from skylimb.spatial import cross, hat
from skylimb.symbolic import Array, clip, exp

DEPTH = 16
"""Ticks of history; at 200 Hz latencies up to 75 ms can be compensated."""


@dataclass(frozen=True)
class DelayCompensation:
    """What is assumed about latency and lag.

    Attributes:
        compensate: off in the paper's presets.
        latency: assumed age of a measurement, s.
        rotor_lag: assumed time constant of the thrusts, s.
        lead: how many times faster than the rotors the thrust is made to follow.
    """

    compensate: bool = False
    latency: float = 0.02
    rotor_lag: float = 0.05
    lead: float = 2.0

    def __post_init__(self) -> None:
        require_range("delay", "latency", self.latency, 0.0, 0.2, "s")
        require_range("delay", "rotor_lag", self.rotor_lag, 1e-4, 1.0, "s")
        require_range("delay", "lead", self.lead, 1.0, 10.0)


class DelayState(NamedTuple):
    """Modelled thrusts (n,) in N, and the known wrench of the last ticks, newest first.

    Each entry of `wrenches` is (6,): rotor force less weight in W (N), rotor torque less gyroscopic in C
    (N m).
    """

    thrusts: Array
    wrenches: tuple[Array, ...]


def initial_delay_state(hover_thrusts: np.ndarray) -> DelayState:
    """A robot that has been hovering for as long as the history goes back."""
    return DelayState(np.asarray(hover_thrusts, dtype=float), (np.zeros(6),) * DEPTH)


def require_history(gains: DelayCompensation, dt: float) -> None:
    """Raise a `ConfigError` unless the history, in ticks of `dt` (s), reaches back to the latency."""
    longest = (DEPTH - 1) * dt
    if gains.compensate and gains.latency > longest + 1e-9:
        raise ConfigError(
            f"delay.latency = {gains.latency:g} s cannot be compensated with a history of {DEPTH} ticks of "
            f"{dt:g} s: at most {longest:g} s, or a lower controller_rate"
        )


def lead_thrusts(
    gains: Any, state: DelayState, thrusts: Array, thrust_min: Array, thrust_max: Array, dt: float
) -> tuple[Array, Array, Array]:
    """The command that makes the rotors follow their wish faster.

    Args:
        gains: a `DelayCompensation`.
        state: of the last tick.
        thrusts: wanted, within the limits, N, (n,).
        thrust_min: N, (n,).
        thrust_max: N, (n,).
        dt: control period, s.

    Returns:
        The command within the limits, the modelled mean thrust of the tick to come, and the modelled thrust
        at its end, all N, (n,).
    """
    decay = exp(-dt / gains.rotor_lag)
    # More would lead past the wish, and ring.
    lead = clip(gains.lead, 1.0, 1.0 / (1.0 - decay))
    command = clip(state.thrusts + lead * (thrusts - state.thrusts), thrust_min, thrust_max)
    away = state.thrusts - command
    mean = command + away * (gains.rotor_lag / dt) * (1.0 - decay)
    return command, mean, command + away * decay


def remember(state: DelayState, thrusts: Array, wrench: Array) -> DelayState:
    """The state with the known wrench (6,) of the tick to come, and the thrusts at its end."""
    return DelayState(thrusts, (wrench, *state.wrenches[:-1]))


def delayed_wrench(gains: Any, state: DelayState, dt: float) -> Array:
    """Known wrench (6,) that acted over the last tick that the next measurement shows the end of."""
    ticks = clip(gains.latency / dt, 0.0, DEPTH - 1.0)
    return sum(
        (wrench * clip(1.0 - abs(ticks - index), 0.0, 1.0) for index, wrench in enumerate(state.wrenches)),
        start=0.0 * state.wrenches[0],
    )


def predict(gains: Any, state: DelayState, body: BodyState, external: Wrench, dt: float) -> BodyState:
    """The body's state now, from the one that was measured `latency` ago.

    Args:
        gains: a `DelayCompensation`.
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
    turn = np.linalg.solve if isinstance(inertia, np.ndarray) else _solve
    spin = turn(inertia, impulse[3:6] + latency * external.torque)
    angle = turn(inertia, moment[3:6] + 0.5 * latency**2 * external.torque)
    return body._replace(
        position=body.position + latency * body.velocity + shift,
        velocity=body.velocity + push,
        R_WC=body.R_WC @ _small_rotation(latency * body.angular_velocity + angle),
        angular_velocity=body.angular_velocity + spin,
    )


def _solve(A: Array, b: Array) -> Array:
    import casadi as ca

    return ca.inv_minor(A) @ b


def _small_rotation(v: Array) -> Array:
    """Rotation by a small vector (rad), orthogonal up to third order (Cayley)."""
    # (I - V/2)^-1 (I + V/2) in closed form.
    half = 0.5 * v
    square = half[0] ** 2 + half[1] ** 2 + half[2] ** 2
    V = hat(half)
    return np.eye(3) + (2.0 / (1.0 + square)) * (V + V @ V)


def known_wrench(rotor_force: Array, rotor_torque: Array, body: BodyState) -> tuple[Array, Array]:
    """Rotor force less weight (W, N) and rotor torque less omega x I omega (C, N m)."""
    gyroscopic = cross(body.angular_velocity, body.model.inertia_C @ body.angular_velocity)
    return rotor_force - body.model.mass * GRAVITY, rotor_torque - gyroscopic
