"""One estimate of all parameters from a whole record: prediction errors, least squares, a prior.

Gauss and Newton's steps with exact derivatives for gains of the filter that are held, the last ones for gains
that go with the parameters; Huber's weights for frames that lie beside, and none at all
for those that cannot be true. Noise levels are found from the record itself: of the frames from what is left,
of unknown pushes by the likelihood. The covariance is that of
`studies.calibration.covariance`.

Where the record hardly shows the latency, another way leads to it (`studies.calibration.latency`). The
covariance then is that of the rest with the latency held, and what the latency takes along.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skylimb.studies.calibration.covariance import covariance_of
from skylimb.studies.calibration.fit import Fit, robust_weights
from skylimb.studies.calibration.latency import by_latency
from skylimb.studies.calibration.levels import CALM, USUAL_NOISE, is_pushed, levels, unpushed
from skylimb.studies.calibration.parameters import Parameter, centers, spreads
from skylimb.studies.calibration.record import Record
from skylimb.studies.calibration.steps import Noise

_EVIDENT = 20.0
"""By so much, twice a logarithm, a record is less likely without the pushes that are reported."""

_ROUGH, _SETTLED = 0.03, 1e-3
"""A step below this part of every standard deviation ends a search."""

_ALLOWED = {"rotor_lag": (1e-3, 0.5), "latency": (0.0, 0.2)}
"""What a robot can have, s."""

_MOST_STEPS = 12


SHOWN_BELOW = 0.25
"""A parameter is shown by a flight that leaves less than this part of its prior's standard deviation.

The prior is wide, and a controller's own belief is better than it: with latencies that were known to half of
it the line of `following` was worse than without a calibration.
"""


@dataclass(frozen=True)
class Estimate:
    """What a record says.

    Attributes:
        parameters: what is estimated, in the order of the flat vectors.
        value: the estimate, (p,).
        covariance: of it, (p, p).
        information: of the record alone, without the prior, (p, p).
        noise: levels that the record was found to have.
        before: residuals with what was believed before, a row a frame, (k, 6).
        after: with the estimate.
        times: of those frames, s.
        left_out: how many frames besides could not be true.
        unpushed: by how much, twice a logarithm, the record is less likely with the least pushes.
    """

    parameters: tuple[Parameter, ...]
    value: np.ndarray
    covariance: np.ndarray
    information: np.ndarray
    noise: Noise
    before: np.ndarray
    after: np.ndarray
    times: np.ndarray
    left_out: int
    unpushed: float

    @property
    def deviation(self) -> np.ndarray:
        """Standard deviation of every entry, (p,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> np.ndarray:
        """Of the entries, (p, p)."""
        deviation = self.deviation
        return self.covariance / np.outer(deviation, deviation)

    @property
    def shown(self) -> np.ndarray:
        """Whether the record shows each entry, (p,)."""
        return self.deviation < SHOWN_BELOW * spreads(self.parameters)

    @property
    def pushed(self) -> bool:
        """Whether the record clearly has more unknown pushes or torques than the least that are tried.

        In some seconds a level ten times the least is as likely as that: it tells nothing.
        """
        return self.unpushed > _EVIDENT

    @property
    def labels(self) -> list[str]:
        """A name for every entry."""
        return [label for one in self.parameters for label in one.labels]


def estimate(record: Record) -> Estimate:
    """The parameters that explain a record best, and how well it shows each."""
    fit = Fit(record)
    noise = USUAL_NOISE
    theta = _search(fit, centers(fit.parameters), noise, _ROUGH)
    fit.leave_out(fit.filtered(theta, noise))
    theta, noise = _settle(fit, theta, noise)
    if is_pushed(noise):
        calm = _settle(fit, _search(fit, centers(fit.parameters), CALM, _ROUGH), CALM)
        if _unlikely(fit, *calm) < _unlikely(fit, theta, noise) - _EVIDENT:
            theta, noise = calm
    theta, along = _by_latency(fit, theta, noise)
    held = None if along is None else fit.places["latency"].start
    theta = _search(fit, theta, noise, _ROUGH, held, whole=True)
    known, (predicted, _) = fit.filtered(theta, noise), fit.whole(theta, noise)
    information, covariance = covariance_of(fit, predicted, fit.predicted(theta, known, chord=True), along)
    frames = [one.residuals.any(axis=1) for one in known]
    before = fit.filtered(centers(fit.parameters), noise)
    times = [
        np.arange(begin, end, record.stride)[fresh] * record.dt
        for (begin, end), fresh in zip(record.pieces, frames, strict=True)
    ]
    return Estimate(
        fit.parameters,
        theta,
        covariance,
        information,
        noise,
        np.concatenate([one.residuals[fresh] for one, fresh in zip(before, frames, strict=True)]),
        np.concatenate([one.residuals[fresh] for one, fresh in zip(known, frames, strict=True)]),
        np.concatenate(times),
        sum(int(bad.sum()) for bad in fit.impossible),
        unpushed(fit, theta, noise),
    )


def _settle(fit: Fit, theta: np.ndarray, noise: Noise) -> tuple[np.ndarray, Noise]:
    """Parameters and levels of noise that suit each other, from some that are near."""
    for settled in (_ROUGH, _SETTLED):
        # Parameters that are a little off look like pushes, so levels are found twice.
        noise = levels(fit, theta, noise)
        theta = _search(fit, theta, noise, settled)
    return theta, noise


def _unlikely(fit: Fit, theta: np.ndarray, noise: Noise) -> float:
    """Minus twice the logarithm of the likelihood, with the prior's."""
    prior = (theta - centers(fit.parameters)) / spreads(fit.parameters)
    return fit.likelihood(fit.filtered(theta, noise)) + float(np.sum(prior**2))


def _by_latency(fit: Fit, theta: np.ndarray, noise: Noise) -> tuple[np.ndarray, np.ndarray | None]:
    """See `studies.calibration.latency`."""
    center, spread, at = centers(fit.parameters), spreads(fit.parameters), fit.places["latency"].start

    def unlikely(there: np.ndarray) -> float:
        return _unlikely(fit, there, noise)

    def search(near: np.ndarray) -> np.ndarray:
        return _search(fit, near, noise, _ROUGH, held=at)

    belief = float(center[at]), float(spread[at])
    return by_latency(theta, at, search, unlikely, fit.record.dt, belief)


def _search(
    fit: Fit, theta: np.ndarray, noise: Noise, settled: float, held: int | None = None, whole: bool = False
) -> np.ndarray:
    """Gauss and Newton's steps until all are small against what the record leaves unknown.

    Args:
        fit: to the record.
        theta: to begin with.
        noise: of the record.
        settled: part of every spread below which a step is small.
        held: entry that stays.
        whole: with gains of the filter that go with the parameters; it runs twice for each of them.
    """
    center, spread = centers(fit.parameters), spreads(fit.parameters)
    for _ in range(_MOST_STEPS):
        predicted, growth = (
            fit.whole(theta, noise) if whole else (fit.predicted(theta, fit.filtered(theta, noise)), 0.0)
        )
        residuals = np.concatenate([one.residuals.ravel() for one in predicted])
        J = np.concatenate([one.by_parameters.reshape(-1, len(theta)) for one in predicted])
        weight, usual = robust_weights(residuals)
        # A poor model is no reason to believe its derivative beyond what the prior bears.
        H = (J * weight[:, None]).T @ J / usual**2 + np.diag(spread**-2)
        slope = (J * weight[:, None]).T @ residuals / usual**2 + 0.5 * growth + (theta - center) / spread**2
        free = np.arange(len(theta)) != held
        step = np.zeros(len(theta))
        step[free] = -np.linalg.solve(H[np.ix_(free, free)], slope[free])
        theta = theta + step
        for name, (low, high) in _ALLOWED.items():
            theta[fit.places[name]] = np.clip(theta[fit.places[name]], low, high)
        if np.all(np.abs(step) < settled * spread):
            break
    return theta
