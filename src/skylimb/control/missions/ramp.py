"""A way along a straight line whose speed rises, stays and falls again."""

from __future__ import annotations

import numpy as np

RAMP = 0.5
"""Time in s over which the speed rises, and over which it falls."""


def ramp_duration(distance: float, speed: float) -> float:
    """Time in s that `ramp` takes; over a short distance the speed stays lower."""
    speed = min(speed, distance / RAMP) if distance > 0.0 else speed
    return distance / speed + RAMP if distance > 0.0 else 0.0


def ramp(distance: float, speed: float, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position, speed and acceleration at times t: a trapezoid of speed from t = 0, at rest before and after.

    Args:
        distance: m.
        speed: of the level part, m/s.
        t: s, (k,).

    Returns:
        Position (m), speed (m/s) and acceleration (m/s^2) along the line, each (k,).
    """
    if distance <= 0.0:
        return np.zeros_like(t), np.zeros_like(t), np.zeros_like(t)
    speed = min(speed, distance / RAMP)
    slope = speed / RAMP
    total = ramp_duration(distance, speed)
    t = np.clip(t, 0.0, total)
    rising, falling = t < RAMP, t > total - RAMP
    left = total - t
    position = np.where(
        rising,
        0.5 * slope * t**2,
        np.where(falling, distance - 0.5 * slope * left**2, speed * (t - 0.5 * RAMP)),
    )
    rate = np.where(rising, slope * t, np.where(falling, slope * left, speed))
    inside = (t > 0.0) & (t < total)
    return position, rate, np.where(rising & inside, slope, np.where(falling & inside, -slope, 0.0))
