"""What a surface does to a pen across the contact axis, learnt while it slides.

While the pen is pressed with a share e of the wanted force, the contact pushes across the axis with

    f = e (l - F d),

where d is the direction in which the path goes, F the friction, and l what does not turn with the path, a
slope above all. The observer shows that force late, and so comes whatever is made of it. But where the path
goes is known, so the force is known before it acts. With the direction d' behind the same lag as the
observer's,

    r = f / e - (l - F d'),        l <- l + k r dt,        F <- F - k (r . d') dt,

both only while the path goes on. The way of the pen tells of a slope as well, sooner and without friction: a
surface that rises by s per metre of way pushes back with s N where it is pressed with N, so

    l <- l + k_s (s N / e - l) dt / (1 + P / 0.05^2),

with P the variance of s. A path that is fast turns soon, and there the force tells; a board that sways under
it would look like a slope. So k_s is less from 0.05 m/s on, and 0 from 0.1 m/s. On a path with a force of its
own, e is that force in N, and l and F are for each newton.

A pen that friction holds is behind its path, in a small bow by a third of the turn, and then friction does
not oppose the path. So on a small stroke d is the direction of v + k_c (p_path - p), with v the velocity of
the path: that of the way by which the pen gets to its place, which it takes while the path rests, too.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.symbolic import Array, clip, low_pass, vector, where

MOST = 1.5
"""Bound of l along each axis, and of F, N: a wrong estimate may not push harder than a surface can."""
SURE = 0.05
"""Standard deviation of a slope that is known."""
FAST = 0.1
"""Speed of the path from which the force alone tells, m/s."""
_LEAST_SHARE, _MOST_SHARE = 0.3, 20.0
"""Below that share of the wanted force nothing is learnt; above 1 it is a force in N."""


@configuration
class FrictionGains:
    """How friction is learnt."""

    rate: Annotated[float, Key("1/s", "k, rate at which it is learnt", low=0.0, high=100.0)] = 0.3
    first: Annotated[float, Key("N", "F before the first slide", low=0.0, high=MOST)] = 0.3
    lag: Annotated[
        float, Key("1/s", "bandwidth of the force that is seen; about the observer's", above=0.0, high=1e3)
    ] = 8.0
    speed: Annotated[
        float, Key("m/s", "speed of the path from which friction counts in full", above=0.0, high=1.0)
    ] = 0.01
    chase: Annotated[
        float,
        Key("1/s", "k_c, how soon a pen on a small stroke goes to its place", low=0.0, high=100.0),
    ] = 0.0
    slope_rate: Annotated[
        float, Key("1/s", "k_s, rate at which l follows a slope that the pen climbs", low=0.0, high=100.0)
    ] = 1.5


class Climbed(NamedTuple):
    """What the way of the pen says of the slope, along the sliding axes.

    Attributes:
        lean: force with which the slope pushes back, for the whole wanted force, N, (2,).
        variance: of the slope, (2,).
        speed: of the path, however slowly it is gone along, m/s.
    """

    lean: Array
    variance: Array
    speed: Any


class FrictionState(NamedTuple):
    """What is learnt: l (2,), N, and F, N; the direction behind the lag, d' (2,)."""

    lean: Array
    friction: Any
    going: Array


def initial_friction_state(gains: FrictionGains) -> FrictionState:
    """No slope, the friction that is assumed, at rest."""
    return FrictionState(np.zeros(2), gains.first, np.zeros(2))


def direction(gains: Any, path: Array) -> Array:
    """d, (2,): unit vector of the path's velocity, shorter below `speed`; zero at rest."""
    speed = (path[0] ** 2 + path[1] ** 2) ** 0.5
    share = clip(speed / gains.speed, 0.0, 1.0) / (speed + 1e-9)
    return vector(path[0] * share, path[1] * share)


def expected_across(state: FrictionState, share: Any, d: Array) -> Array:
    """The force f = e (l - F d), N, (2,), for a share e of the wanted force."""
    return vector(*(share * (state.lean[i] - state.friction * d[i]) for i in (0, 1)))


def follow_friction(
    gains: Any, state: FrictionState, seen: Array, share: Any, path: Array, climbed: Climbed, dt: float
) -> FrictionState:
    """One tick of learning.

    Args:
        gains: `FrictionGains`.
        state: of the last tick.
        seen: estimated force in the sliding plane, N, (2,).
        share: e, of the wanted force with which the pen is pressed; 0 without touch.
        path: velocity of the path in the sliding plane, m/s, (2,).
        climbed: what is known of the slope.
        dt: control period, s.
    """
    d, touching = direction(gains, path), where(share > 0.0, 1.0, 0.0)
    going = vector(*(low_pass(state.going[i], d[i] * touching, gains.lag, dt) for i in (0, 1)))
    length = (going[0] ** 2 + going[1] ** 2) ** 0.5
    # A path that begins or turns shows the pen stick rather than slip.
    rate = gains.rate * dt * clip(2.0 * length - 1.0, 0.0, 1.0) * where(share > _LEAST_SHARE, 1.0, 0.0)
    whole = clip(share, _LEAST_SHARE, _MOST_SHARE)
    error = [seen[i] / whole - state.lean[i] + state.friction * going[i] for i in (0, 1)]
    follows = gains.slope_rate * dt * touching * clip(2.0 - 2.0 * climbed.speed / FAST, 0.0, 1.0)
    rise = [
        follows * (climbed.lean[i] - state.lean[i]) / (1.0 + climbed.variance[i] / SURE**2) for i in (0, 1)
    ]
    lean = vector(*(clip(state.lean[i] + rate * error[i] + rise[i], -MOST, MOST) for i in (0, 1)))
    along = error[0] * going[0] + error[1] * going[1]
    return FrictionState(lean, clip(state.friction - rate * along, 0.0, MOST), going)
