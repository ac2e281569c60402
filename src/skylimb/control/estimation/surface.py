"""Height and slope of the surface under the pen, estimated from where the pen has been.

In the frame of the task (contact axis a, sliding axes u and v) the surface near the tip is the plane
w = w_0 + s_u du + s_v dv, with w along a. A Kalman filter on (w, s_u, s_v) moves along with the tip,

    w <- w + s_u du + s_v dv,      P <- A P A^T + |d| diag(0, q, q),      measured: w of the tip,

so that the slope drifts with the distance travelled, never with time: a pen at rest learns nothing. A pen
that lands again after a lift measures how far the surface has risen on the way. The other direction than that
of the path is seen by the force: friction acts against the slip, so what the contact pushes across the path
(tangent b) can only be the slope's, f . b = s_b f . a.

The outward normal of the surface, which points to the robot, is n = -(a - s_u u - s_v v) / |...|.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.control.estimation.kalman import corrected
from skylimb.symbolic import Array, clip, dot, exp, matrix, vector, where


@configuration
class SurfaceGains:
    """What is assumed about pen and surface."""

    drift: Annotated[
        float, Key("1/m", "growth of the slope's variance for a metre of path", above=0.0, high=1e6)
    ] = 0.5
    height_noise: Annotated[
        float,
        Key(
            "m", "standard deviation of the tip's measured place along the contact axis", above=0.0, high=1.0
        ),
    ] = 0.003
    cross_noise: Annotated[
        float,
        Key(
            "",
            "standard deviation of the slope across the path that one tick's force shows",
            above=0.0,
            high=1e9,
        ),
    ] = 3.0


SMOOTHING = 0.1
"""Time constant of the low pass on the tip's place in the sliding plane, s."""

REST_SPEED = 0.03
"""Speed of the tip's place behind that low pass that may be noise alone, m/s."""

DOUBTFUL = 3.0
"""So many standard deviations from where it was expected a landing shows another surface, or a step."""

STEEPEST = 2.0
"""No slope is believed to be steeper, 1."""

_START = np.diag([0.05**2, 0.3**2, 0.3**2])
"""Before the first touch: 5 cm, and a slope of 17 degrees."""


class SurfaceState(NamedTuple):
    """Estimate (w in m, s_u, s_v), its covariance (3, 3), and the tip's last place (u, v) in m.

    Without arguments it is a surface across the contact axis, somewhere.
    """

    estimate: Array = np.zeros(3)
    covariance: Array = _START
    place: Array = np.zeros(2)


def follow_surface(
    gains: Any,
    state: SurfaceState,
    place: Array,
    touching: Any,
    fresh: Any,
    flown: Array,
    across: Array,
    dt: float,
) -> SurfaceState:
    """One step of the filter.

    Args:
        gains: a `SurfaceGains`.
        state: of the last tick.
        place: of the tip in the task's frame (w, u, v), m, (3,).
        touching: 1 while the tip touches for sure, else 0: nothing is learnt in the air.
        fresh: 1 at the first tick of a touch, where the place is taken as it is.
        flown: way (u, v) from where the tip touched last to where it lands on a surface that it knows, m;
            zeros else.
        across: (3,): direction b across the path, (u, v), and the slope that the force shows along it;
            zeros where it shows none.
        dt: control period, s.
    """
    # The place of a tip at rest wanders by its noise; as much is taken off every way.
    calm = state.place + (1.0 - exp(-dt / SMOOTHING)) * (place[1:3] - state.place)
    calm = calm + fresh * (place[1:3] - calm)
    du, dv = (calm[0] - state.place[0]) * (1.0 - fresh), (calm[1] - state.place[1]) * (1.0 - fresh)
    travelled = (du**2 + dv**2 + 1e-16) ** 0.5
    way = touching * clip(travelled - REST_SPEED * dt, 0.0, 1.0)
    du, dv = du * touching, dv * touching
    du, dv = du + flown[0], dv + flown[1]
    square = flown[0] ** 2 + flown[1] ** 2
    again = where(square > 0.0, 1.0, 0.0)
    away = again * (square + 1.0 - again) ** 0.5  # a root of 0 has no derivative
    A = matrix([[1.0, du, dv], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    x = A @ state.estimate
    P = A @ state.covariance @ A.T + (way + away) * gains.drift * np.diag([0.0, 1.0, 1.0])
    # The slope may have changed all along a way in the air.
    P = P + gains.drift * away**3 * np.diag([1.0, 0.0, 0.0])
    expected = (place[0] - x[0]) ** 2 < DOUBTFUL**2 * (P[0, 0] + gains.height_noise**2)
    known = again * where(expected, 1.0, 0.0)
    x = vector(x[0] + fresh * (1.0 - known) * (place[0] - x[0]), x[1], x[2])
    # A measurement counts as much as the way that it stands for.
    moved = way / (way + REST_SPEED * dt)
    height = vector(1.0, 0.0, 0.0)
    x, P = corrected(
        x, P, height, place[0] - x[0], gains.height_noise**2, touching * (fresh + (1.0 - fresh) * moved)
    )
    slope = vector(0.0, across[0], across[1])
    known = (across[0] ** 2 + across[1] ** 2) * touching * moved
    x, P = corrected(
        x, P, slope, across[2] - (slope[1] * x[1] + slope[2] * x[2]), gains.cross_noise**2, known
    )
    x = vector(x[0], clip(x[1], -STEEPEST, STEEPEST), clip(x[2], -STEEPEST, STEEPEST))
    return SurfaceState(x, P, calm)


def expected_height(gains: Any, state: SurfaceState, du: Any, dv: Any) -> tuple[Any, Any]:
    """Where the surface is expected so far from where the tip touched last, and its standard deviation, m.

    Args:
        gains: a `SurfaceGains`.
        state: of the surface.
        du: way from there along the sliding axis u, m.
        dv: the same along v, m.
    """
    away, toward = (du**2 + dv**2) ** 0.5, vector(1.0, du, dv)
    # The slope may have changed all along the way.
    variance = dot(toward, state.covariance @ toward) + gains.drift * away**3
    return dot(toward, state.estimate), variance**0.5
