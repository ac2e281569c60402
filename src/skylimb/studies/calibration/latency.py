"""The latency of a record in which little moves, by the profile of its likelihood.

There the derivative by the latency is that of the commands' jitter, which says nothing a tick farther: Gauss
and Newton's steps end where they began, and J^T J shows a latency that the record does not. So the likelihood
is looked at a tick to either side. Unless it falls as steeply there as where a record shows the latency, it
is profiled over all that a robot can have. A parabola through the profile says what is likely: its middle,
its width, and how unsure the profile's own roughness makes the middle.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

_STEEP = 50.0
"""By so much, twice a logarithm, the likelihood falls within a tick where a record shows the latency."""

_LATENCIES = np.arange(0.0, 0.0441, 0.004)
"""At which it is profiled, s."""

_FAR, _LEAST = 60.0, 5
"""What is less likely by more has no part in the parabola; but so many points have."""

_ROUGH = 2.0
"""Times the usual roughness from which a point weighs less."""


def by_latency(
    theta: np.ndarray,
    at: int,
    search: Callable[[np.ndarray], np.ndarray],
    unlikely: Callable[[np.ndarray], float],
    tick: float,
    belief: tuple[float, float],
) -> tuple[np.ndarray, np.ndarray | None]:
    """The parameters by that profile, where it is needed.

    Args:
        theta: that a search found, (p,).
        at: entry of the latency.
        search: of the parameters for which the latency stays, from some that are near.
        unlikely: minus twice the logarithm of the likelihood of parameters, with their prior.
        tick: of the record, s.
        belief: centre and standard deviation of the latency before the flight, s.

    Returns:
        The parameters, and how they go with one standard deviation of the latency, (p,); None where the
        record shows the latency, and the parameters are those that were given.
    """

    def held(latency: float, near: np.ndarray) -> np.ndarray:
        there = near.copy()
        there[at] = latency
        return search(there)

    profile = [held(max(theta[at] + side, 0.0), theta) for side in (tick, -tick)]
    if min(map(unlikely, profile)) > unlikely(theta) + _STEEP:
        return theta, None
    for latency in _LATENCIES:
        profile.append(held(float(latency), profile[-1]))
    cost, places = np.array([unlikely(one) for one in profile]), np.array(profile)
    near = cost <= max(cost.min() + _FAR, np.sort(cost)[_LEAST - 1])
    likely, deviation = likely_latency(places[near, at], cost[near], belief)
    along = np.polyfit(places[near, at], places[near], 1)[0]
    return held(likely, places[np.argmin(np.abs(places[:, at] - likely))]), deviation * along


def likely_latency(
    latencies: np.ndarray, cost: np.ndarray, belief: tuple[float, float]
) -> tuple[float, float]:
    """Value and standard deviation of a latency by a rough profile, s; the belief where that has no bottom.

    Args:
        latencies: s, (k,).
        cost: minus twice the logarithm of the likelihood at each, (k,).
        belief: centre and standard deviation before the flight, s.
    """
    center, spread = belief
    x = (latencies - center) / spread
    rough = np.abs(cost - np.polyval(np.polyfit(x, cost, 2), x))
    usual = max(float(np.median(rough)), 1e-9)
    weight = np.minimum(1.0, _ROUGH * usual / np.maximum(rough, usual))
    (bend, slope, _), unsure = np.polyfit(x, cost, 2, w=weight, cov=True)
    if bend < 1.0:  # flatter than the belief
        return belief
    middle = -0.5 * slope / bend
    by = np.array([-middle / bend, -0.5 / bend, 0.0])
    deviation = float(np.sqrt(1.0 / bend + by @ unsure @ by))
    return max(float(center + spread * middle), 0.0), spread * min(deviation, 1.0)
