"""Motion that is there to be measured: sums of sines on the centre of gravity's place and on the heading.

Sines put all of their power where it was planned, and a few of them tell the parts of a model apart that a
single one confuses: a lag from a latency, a tilted sensor from a centre of gravity that lies higher. They
come and go smoothly, and the reference of the acceleration is sent along, so that the thrusts follow them
beyond the controller's own bandwidth.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.control.planning.smooth_step import quintic

Sine = tuple[float, float, float]
"""Amplitude (m or rad), frequency (Hz), phase (rad)."""

FADE = 2.0
"""Time over which the motion comes and goes, s; at most half of the time there is."""


def _sines(meaning: str, unit: str = "m") -> Key:
    return Key(
        "", f"{meaning}; amplitude in {unit}, frequency in Hz and phase in rad of each", low=-20.0, high=20.0
    )


@configuration
class ExcitationConfig:
    """Sines on top of the path while it lasts, along the axes of W."""

    x: Annotated[tuple[Sine, ...], _sines("sines on the centre of gravity's x")] = ()
    y: Annotated[tuple[Sine, ...], _sines("the same on y")] = ()
    z: Annotated[tuple[Sine, ...], _sines("the same on z")] = ()
    heading: Annotated[tuple[Sine, ...], _sines("sines on the heading", "rad")] = ()

    @property
    def empty(self) -> bool:
        """Whether there is nothing to add."""
        return not (self.x or self.y or self.z or self.heading)


class Excitation(NamedTuple):
    """What comes on top of the references at times (k,).

    Attributes:
        position: W, m, (k, 3).
        velocity: m/s, (k, 3).
        acceleration: m/s^2, (k, 3).
        heading: rad, (k,).
    """

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    heading: np.ndarray


def excitation(config: ExcitationConfig, t: np.ndarray, duration: float) -> Excitation:
    """The motion at times t (k,), s, since it began; nothing before it, nor after `duration` s."""
    ways = [_sum_of_sines(sines, t, duration) for sines in (config.x, config.y, config.z)]
    position, velocity, acceleration = (np.stack(parts, axis=1) for parts in zip(*ways, strict=True))
    heading, _, _ = _sum_of_sines(config.heading, t, duration)
    return Excitation(position, velocity, acceleration, heading)


def _sum_of_sines(
    sines: tuple[Sine, ...], t: np.ndarray, duration: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Value, rate and second derivative of faded sines, (k,) each."""
    size, rate, bend = _envelope(t, duration)
    value, slope, curvature = np.zeros(t.shape), np.zeros(t.shape), np.zeros(t.shape)
    for amplitude, frequency, phase in sines:
        w = 2.0 * math.pi * frequency
        sine, cosine = amplitude * np.sin(w * t + phase), amplitude * np.cos(w * t + phase)
        value += size * sine
        slope += rate * sine + size * w * cosine
        curvature += bend * sine + 2.0 * rate * w * cosine - size * w**2 * sine
    return value, slope, curvature


def _envelope(t: np.ndarray, duration: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Up from 0 to 1 and down again, with its two derivatives."""
    fade = min(FADE, 0.5 * duration)
    if fade <= 0.0:
        return np.zeros(t.shape), np.zeros(t.shape), np.zeros(t.shape)
    up = quintic(np.clip(t / fade, 0.0, 1.0))
    down = quintic(np.clip((duration - t) / fade, 0.0, 1.0))
    first = t < 0.5 * duration
    return (
        np.where(first, up[0], down[0]),
        np.where(first, up[1], -down[1]) / fade,
        np.where(first, up[2], down[2]) / fade**2,
    )
