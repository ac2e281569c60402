"""A surface that moves on a slide: it advances once, it sways, or both."""

from __future__ import annotations

import numpy as np

_RAMP = 0.2  # s over which an advancing surface gathers and loses speed


def advance(t: np.ndarray, distance: float, speed: float, start: float) -> tuple[np.ndarray, np.ndarray]:
    """Displacement (m) and velocity (m/s) at times `t` (s) of a surface that moves once, from `start`.

    Speed rises and falls as half a cosine over 0.2 s, so that no contact feels a jump of velocity.
    """
    duration = abs(distance) / speed
    direction = np.sign(distance) * speed
    rise, fall = _ramp(t - start), _ramp(t - start - duration)
    return direction * (rise[0] - fall[0]), direction * (rise[1] - fall[1])


def sway(t: np.ndarray, amplitude: float, frequency: float) -> tuple[np.ndarray, np.ndarray]:
    """Displacement (m) and velocity (m/s) at times `t` (s) of a sine (m, Hz)."""
    omega = 2.0 * np.pi * frequency
    return amplitude * np.sin(omega * t), amplitude * omega * np.cos(omega * t)


def _ramp(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A unit of speed that is gathered over the ramp, and its integral."""
    inside = np.clip(t, 0.0, _RAMP)
    angle = np.pi * inside / _RAMP
    travelled = 0.5 * (inside - _RAMP / np.pi * np.sin(angle)) + np.maximum(t - _RAMP, 0.0)
    return travelled, 0.5 * (1.0 - np.cos(angle))
