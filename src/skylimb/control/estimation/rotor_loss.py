"""Which rotor has lost thrust, and how much, by the external wrench that it would explain.

A rotor that gives less than it is commanded looks like a wrench along its own column of the allocation
matrix. A fast observer sees that in some 50 ms. What no single rotor explains is a push.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from skylimb.base.packing import numeric
from skylimb.control.estimation.momentum_observer import ObserverGains, ObserverState, observe
from skylimb.control.estimation.records import BodyState
from skylimb.symbolic import Array, clip, dot, exp, max, min, stack, vector, where, within

_RATE = 30.0
_FAST = numeric(ObserverGains((_RATE, _RATE, _RATE), (_RATE, _RATE, _RATE)))

WHITE = np.array(
    [
        [0.73, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.17, 1.26, 0.0, 0.0, 0.0, 0.0],
        [-0.02, -0.25, 0.65, 0.0, 0.0, 0.0],
        [-0.05, -0.09, -0.48, 2.07, 0.0, 0.0],
        [-0.16, 0.12, 0.14, 0.5, 5.86, 0.0],
        [0.16, -0.36, -0.03, 0.89, 0.31, 3.53],
    ]
)
"""Whitens the residual, force (N) and torque (N m) in {C}: the inverse root of its covariance in flights
without fault, of hydrus_xi_quad with the sensors' noise as it ships. Others need their own."""

THRESHOLD, UNEXPLAINED, LEAST = 6.0, 0.45, 0.1
"""Size of the whitened residual that is a fault (flights without one reach 4.7), share of its square that a
loss may leave, and least loss."""

SETTLE, BEFORE = 0.02, 0.02
"""Seconds for which a loss has to show before its share is believed, and for which it has acted at least when
it begins to show: from then on is known how much of it the observer has seen."""

TARE = 2.0
"""Seconds over which the residual of a flight without fault is averaged."""


class Loss(NamedTuple):
    """What is remembered.

    Attributes:
        observer: the fast one.
        mean: of the residual without fault, {C}, N and N m, (6,).
        time: for which it has been averaged, s.
        shown: for which one rotor has explained what is seen, s.
        left: share of its thrust that each rotor has, (n,).
    """

    observer: ObserverState
    mean: Array
    time: Any
    shown: Any
    left: Array


class Seen(NamedTuple):
    """What a tick shows.

    Attributes:
        shares: that each rotor seems to have lost, (n,); 0 but for the one that explains what is seen.
        lost: the greatest of them.
        pushed: 1 where something pushes that no rotor explains.
    """

    shares: Array
    lost: Any
    pushed: Any


def initial_loss(n_rotors: int) -> Loss:
    """Nothing is lost."""
    return Loss(ObserverState(), np.zeros(6), 0.0, 0.0, np.ones(n_rotors))


def look(
    state: Loss, known: ObserverState, body: BodyState, thrusts: Array, fresh: Any, dt: float
) -> tuple[Loss, Seen]:
    """One step.

    Args:
        state: of the last tick.
        known: an observer that knows the wrench of whole rotors.
        body: as measured.
        thrusts: that the rotors should make, behind their lag, N, (n,).
        fresh: 1 where the body is measured, 0 where it is predicted.
        dt: control period, s.
    """
    fast = state.observer._replace(known_force=known.known_force, known_torque=known.known_torque)
    observer, wrench = observe(_FAST, fast, body, dt)
    Q, n = body.model.allocation_C, state.left.shape[0]
    columns = [Q[:, i] * thrusts[i] for i in range(n)]
    residual = stack(body.R_WC.T @ wrench.force, wrench.torque)
    white = WHITE @ (residual - state.mean)
    square = dot(white, white)
    shares, remains = [], []
    for column in columns:
        a = WHITE @ column
        share = clip(-dot(a, white) / (dot(a, a) + 1e-9), 0.0, 1.0)
        rest = white + a * share
        shares.append(share)
        remains.append(dot(rest, rest))
    least = min(*remains) if n > 1 else remains[0]
    ready = fresh * within(state.time, TARE, np.inf)
    alarm = ready * where(square > THRESHOLD**2, 1.0, 0.0)
    explained = alarm * where(least < UNEXPLAINED * square, 1.0, 0.0)
    here = [explained * where(remain <= least, 1.0, 0.0) * where(share > LEAST, 1.0, 0.0)
            for share, remain in zip(shares, remains, strict=True)]  # fmt: skip
    lost = vector(*(here[i] * shares[i] for i in range(n)))
    shown = where(max(lost) > 0.0, state.shown + dt, 0.0)
    settled = within(shown, SETTLE, np.inf)
    # Of a loss that is known the observer has seen all.
    first = settled * within(state.left, 1.0, np.inf)
    lost = clip(lost / (1.0 - first * exp(-_RATE * (shown + BEFORE))), 0.0, 1.0)
    most = max(lost)
    left = where(lost * settled > 0.0, 1.0 - lost, state.left)
    time = clip(state.time + dt * fresh, 0.0, TARE + dt)
    weight = fresh * (1.0 - alarm) * dt / time if not isinstance(time, float) or time else 0.0
    mean = state.mean + weight * (residual - state.mean)
    pushed = alarm * where(most > LEAST, 0.0, 1.0)
    return Loss(observer, mean, time, shown, left), Seen(lost, most, pushed)
