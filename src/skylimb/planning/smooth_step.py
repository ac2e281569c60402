"""The primitive that paths are timed with: a rate that grows smoothly from zero to one."""

from __future__ import annotations

import numpy as np

STEEPEST = 1.875
"""Largest slope of the smooth step over its mean slope."""


def smooth_step(t: np.ndarray, width: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A rate that grows from 0 at t = 0 to 1 at t = width, and its integral and derivative.

    Returns:
        The integral (t - width/2 after the step), the rate (a quintic in between) and its derivative.
    """
    s = np.clip(t / width, 0.0, 1.0)
    integral = width * s**4 * (2.5 + s * (s - 3.0)) + np.maximum(t - width, 0.0)
    return integral, s**3 * (10.0 + s * (6.0 * s - 15.0)), 30.0 / width * (s * (1.0 - s)) ** 2
