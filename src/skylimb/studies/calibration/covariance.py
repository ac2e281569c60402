"""How certain an estimate is, with the colour that its residuals still have.

With the Jacobian J of the whitened residuals, their covariance Sigma of an autoregressive model, and the
prior's information P, the covariance is

    (J^T J + P)^-1 (J^T Sigma J + P) (J^T J + P)^-1 + e e^T.

How thrusts go between two ticks is not known: the model lets their roots decay, another one the thrusts. e is
how far the estimate would move with the other one.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

from skylimb.studies.calibration.fit import IMPOSSIBLE, Fit
from skylimb.studies.calibration.parameters import spreads
from skylimb.studies.calibration.step_model import MEASURED
from skylimb.studies.calibration.steps import Predicted

_ORDER = 6
"""Of the autoregressive model of each residual."""


def covariance_of(
    fit: Fit, predicted: list[Predicted], otherwise: list[Predicted], along: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Information of the record and covariance of the estimate, with the colour of the residuals.

    Args:
        fit: to the record.
        predicted: with the estimate.
        otherwise: the same with the other way of thrusts between two ticks.
        along: how all goes with a standard deviation of a latency that a profile told, (p,).
    """
    at = fit.places["latency"].start
    count = len(spreads(fit.parameters))
    information, coloured = np.zeros((count, count)), np.zeros((count, count))
    slope = np.zeros(count)
    for channel in range(MEASURED):
        series = [one.residuals[:, channel] for one in predicted]
        model, power = _autoregression(series)
        for one, other in zip(predicted, otherwise, strict=True):
            J = one.by_parameters[:, channel, :]
            if along is not None:
                J = np.where(np.arange(count) == at, 0.0, J)
            information += J.T @ J
            slope += J.T @ (other.residuals[:, channel] - one.residuals[:, channel])
            # Sigma = power A^-1 A^-T, so that J^T Sigma J needs A^-T J: the filter run backwards.
            backwards = np.asarray(lfilter([1.0], model, J[::-1], axis=0))
            coloured += power * (backwards.T @ backwards)
    prior = np.diag(spreads(fit.parameters) ** -2)
    inverse = np.linalg.inv(information + prior)
    covariance = inverse @ (coloured + prior) @ inverse
    away = inverse @ slope
    covariance += np.outer(away, away)
    if along is not None:
        covariance[at] = covariance[:, at] = 0.0
        covariance += np.outer(along, along)
    return information, 0.5 * (covariance + covariance.T)


def _autoregression(series: list[np.ndarray]) -> tuple[np.ndarray, float]:
    """Coefficients (1, a_1, ...) and power of the white noise behind some residuals (Yule and Walker)."""
    length = sum(len(one) for one in series)
    clipped = [np.clip(one, -IMPOSSIBLE, IMPOSSIBLE) for one in series]
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
