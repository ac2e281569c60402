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
from skylimb.symbolic import Array, clip, dot, exp, low_pass, max, min, stack, vector, where, within

_RATE = 30.0
_FAST = numeric(ObserverGains((_RATE, _RATE, _RATE), (_RATE, _RATE, _RATE)))

WHITE = np.array(
    [
        [0.59, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.07, 0.78, 0.0, 0.0, 0.0, 0.0],
        [0.0, -0.1, 0.64, 0.0, 0.0, 0.0],
        [-0.03, -0.03, -0.48, 2.07, 0.0, 0.0],
        [-0.11, 0.05, 0.15, 0.49, 5.79, 0.0],
        [0.03, -0.04, -0.01, 0.24, 0.14, 0.96],
    ]
)
"""Whitens the residual, force (N) and torque (N m) in {C}: the inverse root of its covariance in flights
without fault, of hydrus_xi_quad with the sensors' noise as it ships, and of 1 N sideways and 1 N m of yaw
beside it: those are felt where the arm bends, as it does as soon as thrusts change for a fault. Others need
their own."""

THRESHOLD, FELT, UNEXPLAINED, LEAST = 5.0, 3.0, 0.3, 0.1
"""Size of the whitened residual that is a fault (flights without one reach 4.3), and from which something is
felt; share of its square that a loss may leave, and least loss."""

SETTLE, BEFORE = 0.02, 0.02
"""Seconds for which a loss has to show before its share is believed, and for which it has acted at least when
it begins to show: so is known how much of it the observer has seen at least. A loss near the threshold has
acted for as long as something is felt: it would count for more than it is, each time that it shows anew."""

DOUBT, DOUBTFUL = 0.1, 0.4
"""Seconds by which a push has been felt for longer than not, from which no loss is believed, and the most
that they count up to. A rotor that fails explains what is felt from its first tick on, or the next. A push
bends the arm, and then looks like a lost rotor, for up to .16 s."""

TARE = 2.0
"""Seconds over which the residual of a flight without fault is averaged."""


class Loss(NamedTuple):
    """What is remembered.

    Attributes:
        observer: the fast one.
        mean: of the residual without fault, {C}, N and N m, (6,).
        time: for which it has been averaged, s.
        shown: for which each rotor has explained what is seen, s, (n,).
        felt: for which something has been felt, s.
        pushed: by which a push has been felt for longer than not, s.
        made: thrusts, behind the observer's lag and the measurement's age, N, (n,): what a rotor has lost of
            them is what is felt now.
        left: share of its thrust that each rotor has, (n,).
    """

    observer: ObserverState
    mean: Array
    time: Any
    shown: Array
    felt: Any
    pushed: Any
    made: Array
    left: Array


class Seen(NamedTuple):
    """What a tick shows.

    Attributes:
        shares: that each rotor seems to have lost, (n,); 0 but for the one that explains what is seen.
        lost: the greatest of them.
        sure: the same, of what has shown for long enough to say how much it is.
        pushed: 1 where something pushes that no rotor explains.
    """

    shares: Array
    lost: Any
    sure: Any
    pushed: Any


def initial_loss(n_rotors: int) -> Loss:
    """Nothing is lost."""
    return Loss(
        ObserverState(), np.zeros(6), 0.0, np.zeros(n_rotors), 0.0, 0.0, np.zeros(n_rotors), np.ones(n_rotors)
    )


def look(
    state: Loss, known: ObserverState, body: BodyState, thrusts: Array, age: Any, fresh: Any, dt: float
) -> tuple[Loss, Seen]:
    """One step.

    Args:
        state: of the last tick.
        known: an observer that knows the wrench of whole rotors.
        body: as measured.
        thrusts: that the rotors should make, behind their lag, N, (n,).
        age: of the measurement, s.
        fresh: 1 where the body is measured, 0 where it is predicted.
        dt: control period, s.
    """
    fast = state.observer._replace(known_force=known.known_force, known_torque=known.known_torque)
    observer, wrench = observe(_FAST, fast, body, dt)
    Q, n = body.model.allocation_C, state.left.shape[0]
    made = low_pass(state.made, thrusts, 1.0 / (1.0 / _RATE + age), dt)
    columns = [Q[:, i] * made[i] for i in range(n)]
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
    pushed = alarm * (1.0 - max(vector(*here)))
    doubt = clip(state.pushed + dt * (2.0 * pushed - 1.0), 0.0, DOUBTFUL)
    believed = within(doubt, 0.0, DOUBT)
    lost = vector(*(believed * here[i] * shares[i] for i in range(n)))
    shown = where(lost > 0.0, state.shown + dt, 0.0)
    felt = where(ready * where(square > FELT**2, 1.0, 0.0) > 0.5, state.felt + dt, 0.0)
    settled = within(max(shown), SETTLE, np.inf)
    # Of a loss that is known the observer has seen all; of another one what it can have since it acts.
    first = settled * within(state.left, 1.0, np.inf)
    lost = clip(lost / (1.0 - first * exp(-_RATE * max(max(shown) + BEFORE, felt))), 0.0, 1.0)
    most = max(lost)
    # One rotor explains it: the others are whole.
    left = where(most * settled > 0.0, 1.0 - lost, state.left)
    time = clip(state.time + dt * fresh, 0.0, TARE + dt)
    weight = fresh * (1.0 - alarm) * dt / time if not isinstance(time, float) or time else 0.0
    mean = state.mean + weight * (residual - state.mean)
    return Loss(observer, mean, time, shown, felt, doubt, made, left), Seen(
        lost, most, most * settled, pushed
    )
