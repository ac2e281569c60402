"""Levels of noise that a record has: of unknown pushes by the likelihood, of frames by what is left."""

from __future__ import annotations

import numpy as np

from skylimb.studies.calibration.fit import QUARTILE, Fit
from skylimb.studies.calibration.steps import Noise

USUAL_NOISE = Noise(position=1e-3, attitude=1e-3, push=5e-3, turn=5e-3)
"""Levels to begin with."""

CALM = USUAL_NOISE._replace(push=5e-4, turn=5e-4)
"""Levels to begin with once more.

Where a robot hardly leans, unknown torques explain a centre of gravity that is far too low or too high as
well: a search that begins with them may end beside the truth, with levels of pushes that are not there.
"""

_FACTORS = (10.0, 10.0**0.5)
"""By which levels of unknown pushes are raised and lowered, ever finer."""

_PUSHES = ("push", "turn")

_LEAST_PUSH, _MOST_PUSH = 1e-2, 1e2
"""Multiples of the usual levels beyond which nothing is tried: no model is exact to less."""


def levels(fit: Fit, theta: np.ndarray, noise: Noise) -> Noise:
    """Levels that are likely with some parameters, (p,), searched from others."""
    least, found = _likely(fit, theta, noise)
    for factor in _FACTORS:
        for name in _PUSHES:
            usual = getattr(USUAL_NOISE, name)
            for times in (1.0 / factor, factor):
                while True:
                    level = np.clip(times * getattr(found, name), _LEAST_PUSH * usual, _MOST_PUSH * usual)
                    value, tried = _likely(fit, theta, found._replace(**{name: float(level)}))
                    if value >= least:
                        break
                    least, found = value, tried
    return found


def is_pushed(noise: Noise) -> bool:
    """Whether a level of unknown pushes is above the least that is tried."""
    return any(getattr(noise, name) > 1.001 * _LEAST_PUSH * getattr(USUAL_NOISE, name) for name in _PUSHES)


def unpushed(fit: Fit, theta: np.ndarray, noise: Noise) -> float:
    """By how much, twice a logarithm, a record is less likely with the least pushes."""
    least = {name: _LEAST_PUSH * getattr(USUAL_NOISE, name) for name in _PUSHES}
    with_them, without = (_likely(fit, theta, one)[0] for one in (noise, noise._replace(**least)))
    return without - with_them


def _likely(fit: Fit, theta: np.ndarray, noise: Noise) -> tuple[float, Noise]:
    """How unlikely the record is with these unknown pushes, and the levels of its frames with them."""
    residuals = fit.used(fit.filtered(theta, noise))
    size = np.median(np.abs(residuals), axis=0) / QUARTILE
    noise = noise._replace(
        position=float(noise.position * np.sqrt(np.mean(size[:3] ** 2))),
        attitude=float(noise.attitude * np.sqrt(np.mean(size[3:] ** 2))),
    )
    return fit.likelihood(fit.filtered(theta, noise)), noise
