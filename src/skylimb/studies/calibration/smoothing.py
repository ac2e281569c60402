"""Encoders smoothed, each over as long a time as its own motion allows.

Noise of an angle that is taken for motion is an input that no filter expects: in a hover it made the
likelihood rough over the latency, and intervals too narrow. So each angle is smoothed over the time that
predicts its left-out samples best: generalised cross-validation (Craven and Wahba, 1979).
"""

from __future__ import annotations

import numpy as np
from scipy.signal import savgol_coeffs, savgol_filter

TIMES = (0.06, 0.12, 0.24, 0.48, 0.96)
"""Over which encoders may be smoothed, s."""

_LEAST, _ORDER = 5, 3
"""Samples, and order of the polynomial through them."""


def smoothed(encoders: np.ndarray, used: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Angles and their rates.

    Args:
        encoders: measured angles, rad, (k, n).
        used: ticks that the time is chosen for, (m,).
        dt: control period, s.

    Returns:
        Angles, rad, and rates, rad/s, (k, n) each.
    """
    angles, rates = encoders.copy(), np.zeros_like(encoders)
    best = np.full(encoders.shape[1], np.inf)
    # SciPy fits no polynomial to the encoders of a robot without joints.
    for width in _widths(len(encoders), dt) if encoders.shape[1] else ():
        tried = np.asarray(savgol_filter(encoders, width, _ORDER, axis=0))
        own_share = float(savgol_coeffs(width, _ORDER)[width // 2])
        cost = np.mean((encoders - tried)[used] ** 2, axis=0) / (1.0 - own_share) ** 2
        better = cost < best
        best = np.where(better, cost, best)
        speeds = np.asarray(savgol_filter(encoders, width, _ORDER, deriv=1, delta=dt, axis=0))
        angles, rates = np.where(better, tried, angles), np.where(better, speeds, rates)
    return angles, rates


def _widths(most: int, dt: float) -> list[int]:
    """Odd numbers of samples for `TIMES`, of a record of so many."""
    return sorted({width for time in TIMES if (width := max(_LEAST, 2 * round(0.5 * time / dt) + 1)) <= most})
