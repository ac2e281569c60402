"""The primitive that paths are timed with: the quintic that rises smoothly from zero to one."""

from __future__ import annotations

import numpy as np

STEEPEST = 1.875
"""Largest slope of the quintic over its mean slope."""


def quintic(s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The rise from 0 at s = 0 to 1 at s = 1 with no slope and no curvature at its ends, and its derivatives.

    Args:
        s: where, within 0 .. 1.

    Returns:
        The value, its first derivative by s and its second one.
    """
    gap = s * (1.0 - s)
    return s**3 * (10.0 + s * (6.0 * s - 15.0)), 30.0 * gap**2, 60.0 * gap * (1.0 - 2.0 * s)


def smooth_step(t: np.ndarray, width: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A rate that grows from 0 at t = 0 to 1 at t = width, and its integral and derivative.

    Returns:
        The integral (t - width/2 after the step), the rate (a quintic in between) and its derivative.
    """
    s = np.clip(t / width, 0.0, 1.0)
    integral = width * s**4 * (2.5 + s * (s - 3.0)) + np.maximum(t - width, 0.0)
    rate, slope, _ = quintic(s)
    return integral, rate, slope / width
