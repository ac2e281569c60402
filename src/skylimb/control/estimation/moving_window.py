"""External wrench from the frames of a short window, in which it may drift, and now and then jump.

What is left of the momentum once all that is known to act is taken off has the external wrench as its slope:

    r(t) = h(t) - integral of u,    r_{k+1} = r_k + D_k f_k,    f_{k+1} = f_k + d_k,    seen_k = r_k + noise.

Over the last `FRAMES` frames this is least squares in closed form: a pass of a filter gives what is left of
each frame. A touch is no drift. So each place in the window is tried for one jump of f, whose size is least
squares as well; the best place counts by how much likelier it makes the frames than no jump,

    share = 1 / (1 + exp((doubt - gain) / 2)),      gain: by how much the sum of squares is less.

What lies before the window is kept as a prior, with the jump that was found where it left.

A frame counts where it was made (`capture_age`), so no latency is assumed. h is m p' in W, I omega in C.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.base.packing import chosen
from skylimb.control.estimation.inertial import DEPTH
from skylimb.control.estimation.records import BodyState
from skylimb.symbolic import Array, between, clip, dot, exp, matrix, stack, where

FRAMES = 20
"""In the window; 0.2 s of a motion capture of 100 Hz."""
HALVES = slice(0, 3), slice(3, 6)
"""Of a wrench: force, torque."""
JUMP = 1.0, 0.1
"""Standard deviation of a jump before it is seen: N, N m."""


@configuration
class WindowGains:
    """What drifts and what a frame is off by; standard deviations."""

    force: Annotated[
        float, Key("N", "how far the external force drifts in a second", above=0.0, high=1e3)
    ] = 0.15
    torque: Annotated[
        float, Key("N m", "how far the external torque drifts in a second", above=0.0, high=1e3)
    ] = 0.1
    linear: Annotated[float, Key("N s", "error of a frame's momentum", above=0.0, high=100.0)] = 0.033
    angular: Annotated[float, Key("N m s", "error of a frame's angular momentum", above=0.0, high=10.0)] = (
        0.002
    )
    doubt: Annotated[
        float,
        Key("", "by how much less the squares must be for a jump to be as likely as none", low=0.0, high=1e9),
    ] = 40.0


class Pair(NamedTuple):
    """r and f of a wrench's six axes, and their covariance for force and torque.

    Attributes:
        r: momentum that is left, (6,).
        f: external wrench, (6,).
        P: variances of r, of r with f, and of f, for each half, (2, 3).
    """

    r: Array
    f: Array
    P: Array


class Window(NamedTuple):
    """What is remembered; without arguments that before the first frame.

    Attributes:
        force: estimated external force, W, N.
        torque: estimated external torque, C, N m.
        known_force: rotor force less weight, W, N.
        known_torque: rotor torque less omega x I omega, C, N m.
        started: 0 before the first tick, 1 after it.
        impulses: integral of the known wrench up to the last ticks, newest first.
        age: of the frame that was seen last, s.
        seen: r of the frames, oldest first, (6,) each.
        spans: time from each frame to the next, s.
        jump: that was found behind the oldest frame, (6,).
        prior: of the oldest frame, before it is seen.
    """

    force: Array = np.zeros(3)
    torque: Array = np.zeros(3)
    known_force: Array = np.zeros(3)
    known_torque: Array = np.zeros(3)
    started: Any = 0.0
    impulses: tuple[Array, ...] = (np.zeros(6),) * DEPTH
    age: Any = 0.0
    seen: tuple[Array, ...] = (np.zeros(6),) * FRAMES
    spans: Array = np.zeros(FRAMES - 1)
    jump: Array = np.zeros(6)
    prior: Pair = Pair(np.zeros(6), np.zeros(6), np.array([[1.0, 0.0, 1.0], [1.0, 0.0, 0.01]]))


def looked(gains: Any, state: Window, body: BodyState, age: Any, dt: float) -> Window:
    """One tick.

    Args:
        gains: a `WindowGains`.
        state: of the last tick, with the known wrench that acted since.
        body: as the frame shows it, unsmoothed.
        age: of the frame, s.
        dt: control period, s.
    """
    impulse = state.impulses[0] + dt * stack(state.known_force, state.known_torque)
    impulses = (impulse, *state.impulses[:-1])
    momentum = stack(body.model.mass * body.velocity, body.model.inertia_C @ body.angular_velocity)
    left = momentum - between(impulses, clip(age * (1.0 / dt), 0.0, DEPTH - 1.0))
    first = state._replace(
        seen=tuple(state.started * row + (1.0 - state.started) * left for row in state.seen),
        prior=state.prior._replace(r=state.started * state.prior.r + (1.0 - state.started) * left),
    )
    span = dt + state.age - age
    fresh = state.started * where(span > 0.5 * dt, 1.0, 0.0)
    new = chosen(fresh > 0.5, _next(gains, first, left, span), first)
    return new._replace(impulses=impulses, age=age, started=1.0)


def _next(gains: Any, state: Window, left: Array, span: Any) -> Window:
    """The window one frame later, solved."""
    oldest = _seen(gains, state.prior, state.seen[0])
    prior = _later(gains, oldest._replace(f=oldest.f + state.jump), state.spans[0])
    seen = (*state.seen[1:], left)
    spans = stack(*(state.spans[k] for k in range(1, FRAMES - 1)), span)
    known, jump = _solved(gains, prior, seen, spans)
    return state._replace(force=known[0:3], torque=known[3:6], seen=seen, spans=spans, jump=jump, prior=prior)


def _solved(gains: Any, prior: Pair, seen: tuple[Array, ...], spans: Array) -> tuple[Array, Array]:
    """The wrench of the newest frame, and the jump that was found behind the oldest one."""
    pair, left, weights, gained = prior, list[Array](), list[Any](), list[Any]()
    for k, row in enumerate(seen):
        if k:
            pair = _later(gains, pair, spans[k - 1])
        left.append(row - pair.r)
        sizes = [1.0 / (pair.P[half, 0] + noise**2) for half, noise in enumerate(_noises(gains))]
        weights.append(sizes)
        gained.append([(pair.P[half, 0] * sizes[half], pair.P[half, 1] * sizes[half]) for half in range(2)])
        pair = _seen(gains, pair, row)
    wrench, first = [], []
    for half, axes in enumerate(HALVES):
        best, jump, behind = 0.0, 0.0 * left[0][axes], 0.0 * left[0][axes]
        for j in range(FRAMES - 1):
            shows, stays = _shown(spans, [one[half] for one in gained], j)
            size = JUMP[half] ** -2 + sum(show**2 * weights[k][half] for k, show in shows)
            found = sum(show * weights[k][half] * left[k][axes] for k, show in shows) / size
            gain = size * dot(found, found)
            better = gain > best
            best, jump = where(better, gain, best), where(better, stays * found, jump)
            behind = where(better, found if j == 0 else 0.0 * found, behind)
        share = 1.0 / (1.0 + exp(clip(0.5 * (gains.doubt - best), -50.0, 50.0)))
        wrench.append(pair.f[axes] + share * jump)
        first.append(share * behind)
    return stack(*wrench), stack(*first)


def _shown(spans: Array, gained: list[tuple[Any, Any]], j: int) -> tuple[list[tuple[int, Any]], Any]:
    """What the filter does not expect where f jumps by 1 behind frame j.

    Returns:
        In each later frame, and in f at the end.
    """
    r, f, shows = 0.0, 1.0, list[tuple[int, Any]]()
    for k in range(j + 1, FRAMES):
        r = r + spans[k - 1] * f
        shows.append((k, r))
        r, f = r - gained[k][0] * r, f - gained[k][1] * r
    return shows, f


def _noises(gains: Any) -> tuple[Any, Any]:
    return gains.linear, gains.angular


def _seen(gains: Any, pair: Pair, row: Array) -> Pair:
    """A pair that knows a frame."""
    r, f, P = [], [], []
    for half, noise in enumerate(_noises(gains)):
        a, b, c = pair.P[half, 0], pair.P[half, 1], pair.P[half, 2]
        size = 1.0 / (a + noise**2)
        off = row[HALVES[half]] - pair.r[HALVES[half]]
        r.append(pair.r[HALVES[half]] + (a * size) * off)
        f.append(pair.f[HALVES[half]] + (b * size) * off)
        P.append((a - a * a * size, b - a * b * size, c - b * b * size))
    return Pair(stack(*r), stack(*f), matrix(P))


def _later(gains: Any, pair: Pair, span: Any) -> Pair:
    """A pair one frame later."""
    P = []
    for half, drift in enumerate((gains.force, gains.torque)):
        a, b, c = pair.P[half, 0], pair.P[half, 1], pair.P[half, 2]
        P.append((a + span * (2.0 * b + span * c), b + span * c, c + drift**2 * span))
    return Pair(pair.r + span * pair.f, pair.f, matrix(P))


def rescaled(state: Window, more: Array, dt: float) -> Window:
    """The window where every known wrench of before is greater by `more`, (6,)."""
    since, seen = state.age, [state.seen[-1] + state.age * more]
    for k in reversed(range(FRAMES - 1)):
        since = since + state.spans[k]
        seen.append(state.seen[k] + since * more)
    prior = state.prior._replace(r=state.prior.r + since * more, f=state.prior.f - more)
    impulses = tuple(row - (k * dt) * more for k, row in enumerate(state.impulses))
    return state._replace(seen=tuple(reversed(seen)), prior=prior, impulses=impulses)
