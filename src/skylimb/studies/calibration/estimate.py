"""One estimate of all parameters from a whole record: prediction errors, least squares, a prior.

Gauss and Newton's steps with exact derivatives; Huber's weights for frames that lie beside, and none at all
for those that cannot be true. Noise levels are found from the record itself: of the frames from what is left,
of unknown pushes by the likelihood. The covariance counts the colour that the residuals still have: with the
Jacobian J of the whitened residuals, their covariance Sigma of an autoregressive model, and the prior's
information P, it is

    (J^T J + P)^-1 (J^T Sigma J + P) (J^T J + P)^-1.

Where the record hardly shows the latency, another way leads to it (`studies.calibration.latency`). The
covariance then is that of the rest with the latency held, and what the latency takes along.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

from skylimb.studies.calibration.latency import by_latency
from skylimb.studies.calibration.mechanics import root_mass
from skylimb.studies.calibration.parameters import Parameter, centers, parameters, slices, spreads
from skylimb.studies.calibration.predictor import Predictor
from skylimb.studies.calibration.record import Record
from skylimb.studies.calibration.step_model import MEASURED
from skylimb.studies.calibration.steps import Filtered, Noise, Predicted, Steps

USUAL_NOISE = Noise(position=1e-3, attitude=1e-3, push=5e-3, turn=5e-3)
"""Levels to begin with."""

_FACTORS = (10.0, 10.0**0.5)
"""By which levels of unknown pushes are raised and lowered, ever finer."""

_LEAST_PUSH, _MOST_PUSH = 1e-2, 1e2
"""Multiples of the usual levels beyond which nothing is tried: no model is exact to less."""

_HUBER, _IMPOSSIBLE = 3.0, 8.0
"""Residuals, over their usual size, from which they weigh less, and from which their frame is not used."""

_ROUGH, _SETTLED = 0.03, 1e-3
"""A step below this part of every standard deviation ends a search."""

_ALLOWED = {"rotor_lag": (1e-3, 0.5), "latency": (0.0, 0.2)}
"""What a robot can have, s."""

_MOST_STEPS = 12

_ORDER = 6
"""Of the autoregressive model of each residual."""

SHOWN_BELOW = 0.5
"""A parameter is shown by a flight that leaves less than this part of its prior's standard deviation."""

_QUARTILE = 0.6745


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
    def labels(self) -> list[str]:
        """A name for every entry."""
        return [label for one in self.parameters for label in one.labels]


class Fit:
    """A record with everything that its residuals need, for any parameters.

    Args:
        record: what was flown.
    """

    def __init__(self, record: Record) -> None:
        self.record = record
        self.parameters = parameters(record.robot)
        self.places = slices(self.parameters)
        robot = record.robot
        self.predictor = Predictor(record.wheels, robot.mass, root_mass(robot), record.step)
        self.impossible = [np.zeros(len(range(*piece, record.stride)), dtype=bool) for piece in record.pieces]

    def steps(self, theta: np.ndarray) -> list[Steps]:
        """What is known of every step of every piece, frames that cannot be true left out."""
        lag, latency = float(theta[self.places["rotor_lag"]][0]), float(theta[self.places["latency"]][0])
        made = [self.record.steps(piece, lag, latency) for piece in self.record.pieces]
        return [
            steps._replace(fresh=steps.fresh * ~bad[:, None])
            for steps, bad in zip(made, self.impossible, strict=True)
        ]

    def filtered(self, theta: np.ndarray, noise: Noise) -> list[Filtered]:
        """The filter along every piece."""
        return [
            self.predictor.filtered(steps, theta, noise, self.predictor.start(steps, theta))
            for steps in self.steps(theta)
        ]

    def predicted(self, theta: np.ndarray, known: list[Filtered]) -> list[Predicted]:
        """Residuals and derivatives along every piece, the filter's gains held."""
        return [
            self.predictor.predict(steps, theta, self.predictor.start(steps, theta), one)
            for steps, one in zip(self.steps(theta), known, strict=True)
        ]

    def used(self, known: list[Filtered]) -> np.ndarray:
        """Residuals of the frames that are used, (k, 6)."""
        return np.concatenate([one.residuals[one.residuals.any(axis=1)] for one in known])

    def likelihood(self, known: list[Filtered]) -> float:
        """Minus twice the logarithm of the likelihood, up to a constant; large residuals count as Huber's."""
        total = 0.0
        for one in known:
            fresh = one.residuals.any(axis=1)
            size = np.abs(one.residuals[fresh])
            total += float(np.sum(np.where(size < _HUBER, size**2, _HUBER * (2.0 * size - _HUBER))))
            total -= 2.0 * float(np.sum(np.log(one.whitening[fresh][:, :: MEASURED + 1])))
        return total

    def leave_out(self, known: list[Filtered]) -> None:
        """Use no frame any more whose residual is beyond what any frame could have."""
        usual = np.median(np.abs(self.used(known)), axis=0) / _QUARTILE
        most = _IMPOSSIBLE * np.maximum(usual, 1.0)
        for piece, one in enumerate(known):
            far = np.any(np.abs(one.residuals) > most, axis=1)
            # A wild frame makes those behind it look wild.
            self.impossible[piece] |= far & ~np.concatenate([[False], far[:-1]])


def estimate(record: Record) -> Estimate:
    """The parameters that explain a record best, and how well it shows each."""
    fit = Fit(record)
    noise = USUAL_NOISE
    theta = _search(fit, centers(fit.parameters), noise, _ROUGH)
    fit.leave_out(fit.filtered(theta, noise))
    for settled in (_ROUGH, _SETTLED):
        # Parameters that are a little off look like pushes, so levels are found twice.
        noise = _levels(fit, theta, noise)
        theta = _search(fit, theta, noise, settled)
    theta, along = _by_latency(fit, theta, noise)
    known = fit.filtered(theta, noise)
    predicted = fit.predicted(theta, known)
    information, covariance = _covariance(fit, predicted, along)
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
    )


def _by_latency(fit: Fit, theta: np.ndarray, noise: Noise) -> tuple[np.ndarray, np.ndarray | None]:
    """See `studies.calibration.latency`."""
    center, spread, at = centers(fit.parameters), spreads(fit.parameters), fit.places["latency"].start

    def unlikely(there: np.ndarray) -> float:
        prior = float(np.sum(((there - center) / spread) ** 2))
        return fit.likelihood(fit.filtered(there, noise)) + prior

    def search(near: np.ndarray) -> np.ndarray:
        return _search(fit, near, noise, _ROUGH, held=at)

    belief = float(center[at]), float(spread[at])
    return by_latency(theta, at, search, unlikely, fit.record.dt, belief)


def _search(fit: Fit, theta: np.ndarray, noise: Noise, settled: float, held: int | None = None) -> np.ndarray:
    """Gauss and Newton's steps until all are small against what the record leaves unknown.

    Args:
        fit: to the record.
        theta: to begin with.
        noise: of the record.
        settled: part of every spread below which a step is small.
        held: entry that stays.
    """
    center, spread = centers(fit.parameters), spreads(fit.parameters)
    for _ in range(_MOST_STEPS):
        known = fit.filtered(theta, noise)
        predicted = fit.predicted(theta, known)
        residuals = np.concatenate([one.residuals.ravel() for one in predicted])
        J = np.concatenate([one.by_parameters.reshape(-1, len(theta)) for one in predicted])
        weight, usual = robust_weights(residuals)
        # A poor model is no reason to believe its derivative beyond what the prior bears.
        H = (J * weight[:, None]).T @ J / usual**2 + np.diag(spread**-2)
        slope = (J * weight[:, None]).T @ residuals / usual**2 + (theta - center) / spread**2
        free = np.arange(len(theta)) != held
        step = np.zeros(len(theta))
        step[free] = -np.linalg.solve(H[np.ix_(free, free)], slope[free])
        theta = theta + step
        for name, (low, high) in _ALLOWED.items():
            theta[fit.places[name]] = np.clip(theta[fit.places[name]], low, high)
        if np.all(np.abs(step) < settled * spread):
            break
    return theta


def robust_weights(residuals: np.ndarray) -> tuple[np.ndarray, float]:
    """Huber's weights of residuals, each in the deviations that its noise has, and their usual deviation.

    A residual within some usual deviations counts fully, one beyond pulls no more than one at that bound.
    Zeros are frames that were not measured: they say nothing of what is usual.

    Args:
        residuals: of frames, (k,).

    Returns:
        Weights, (k,), and the usual deviation, at least 1.
    """
    usual = max(1.0, float(np.median(np.abs(residuals[residuals != 0.0]))) / _QUARTILE)
    return np.minimum(1.0, _HUBER * usual / np.maximum(np.abs(residuals), 1e-12)), usual


def _levels(fit: Fit, theta: np.ndarray, noise: Noise) -> Noise:
    """Levels of noise that the record has: of unknown pushes by the likelihood, of frames by what is left."""
    least, found = _likely(fit, theta, noise)
    for factor in _FACTORS:
        for name in ("push", "turn"):
            usual = getattr(USUAL_NOISE, name)
            for times in (1.0 / factor, factor):
                while True:
                    level = np.clip(times * getattr(found, name), _LEAST_PUSH * usual, _MOST_PUSH * usual)
                    value, tried = _likely(fit, theta, found._replace(**{name: float(level)}))
                    if value >= least:
                        break
                    least, found = value, tried
    return found


def _likely(fit: Fit, theta: np.ndarray, noise: Noise) -> tuple[float, Noise]:
    """How unlikely the record is with these unknown pushes, and the levels of its frames with them."""
    residuals = fit.used(fit.filtered(theta, noise))
    size = np.median(np.abs(residuals), axis=0) / _QUARTILE
    noise = noise._replace(
        position=float(noise.position * np.sqrt(np.mean(size[:3] ** 2))),
        attitude=float(noise.attitude * np.sqrt(np.mean(size[3:] ** 2))),
    )
    return fit.likelihood(fit.filtered(theta, noise)), noise


def _covariance(
    fit: Fit, predicted: list[Predicted], along: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Information of the record and covariance of the estimate, with the colour of the residuals.

    Args:
        fit: to the record.
        predicted: with the estimate.
        along: how all goes with a standard deviation of a latency that a profile told, (p,).
    """
    at = fit.places["latency"].start
    count = len(spreads(fit.parameters))
    information, coloured = np.zeros((count, count)), np.zeros((count, count))
    for channel in range(MEASURED):
        series = [one.residuals[:, channel] for one in predicted]
        model, power = _autoregression(series)
        for one in predicted:
            J = one.by_parameters[:, channel, :]
            if along is not None:
                J = np.where(np.arange(count) == at, 0.0, J)
            information += J.T @ J
            # Sigma = power A^-1 A^-T, so that J^T Sigma J needs A^-T J: the filter run backwards.
            backwards = np.asarray(lfilter([1.0], model, J[::-1], axis=0))
            coloured += power * (backwards.T @ backwards)
    prior = np.diag(spreads(fit.parameters) ** -2)
    inverse = np.linalg.inv(information + prior)
    covariance = inverse @ (coloured + prior) @ inverse
    if along is not None:
        covariance[at] = covariance[:, at] = 0.0
        covariance += np.outer(along, along)
    return information, 0.5 * (covariance + covariance.T)


def _autoregression(series: list[np.ndarray]) -> tuple[np.ndarray, float]:
    """Coefficients (1, a_1, ...) and power of the white noise behind some residuals (Yule and Walker)."""
    length = sum(len(one) for one in series)
    clipped = [np.clip(one, -_IMPOSSIBLE, _IMPOSSIBLE) for one in series]
    lags = np.array(
        [
            sum(float(one[lag:] @ one[: len(one) - lag]) for one in clipped) / length
            for lag in range(_ORDER + 1)
        ]
    )
    lags[0] *= 1.0 + 1e-9
    a = solve_toeplitz(lags[:-1], lags[1:])
    used = sum(int(np.count_nonzero(one)) for one in series) / length
    return np.concatenate([[1.0], -a]), float((lags[0] - a @ lags[1:]) / max(used, 1e-9))
