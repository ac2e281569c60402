"""Waves: the sinusoidal wall and the corrugated sheet."""

from __future__ import annotations

from typing import Annotated, Any, Literal, NamedTuple

import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.simulation.surfaces.curved import CurvedSurface
from skylimb.simulation.surfaces.graph import Formula
from skylimb.symbolic import cos, sin


class _Wave(NamedTuple):
    """Amplitude (m), wave number (rad/m) and phase (rad)."""

    amplitude: float
    wave_number: float
    phase: float


def _height(u: Any, v: Any, wave: _Wave) -> Any:
    # With its derivatives: their factors in this order keep flights the same to the bit.
    a, k, angle = wave.amplitude, wave.wave_number, wave.wave_number * u + wave.phase
    return a * sin(angle), a * k * cos(angle), 0.0, -a * k * k * sin(angle), 0.0, 0.0


@configuration
class SineWall(CurvedSurface):
    """A wall w = a sin(2 pi u / wavelength + phase), shifted so that `position` lies on it.

    `roll` turns the waves.
    """

    kind: Literal["sine"] = "sine"
    amplitude: Annotated[float, Key("m", "half of the height from trough to crest", low=0.0, high=2.0)] = 0.1
    wavelength: Annotated[float, Key("m", "from crest to crest", low=0.01, high=100.0)] = 1.2
    phase: Annotated[
        float,
        Key(
            "rad",
            "phase at u = 0: 0 has the wall recede toward +u there, -pi/2 has the crest that is nearest to "
            "the robot",
            low=-6.3,
            high=6.3,
        ),
    ] = 0.0

    def drawn_u(self) -> np.ndarray:
        """Sixteen places along u for each wave."""
        count = int(min(max(121.0, 16.0 * self.size[0] / self.wavelength), 801.0))
        return np.linspace(-0.5, 0.5, count) * self.size[0]

    def make_shape(self) -> Formula:
        """The sine as a shape; its hollows are those of its troughs."""
        wave = _Wave(self.amplitude, 2.0 * np.pi / self.wavelength, self.phase)
        return Formula(_height, wave, (0.5 * self.size[0], 0.5 * self.size[1]))

    @property
    def tightest_hollow(self) -> float:
        """The radius of curvature at a trough, 1 / (a k^2), m."""
        k = 2.0 * np.pi / self.wavelength
        return 1.0 / (self.amplitude * k**2) if self.amplitude else float("inf")


@configuration
class Corrugated(SineWall):
    """A corrugated sheet: the sine of a roofing sheet, 18 mm deep every 76 mm."""

    kind: Literal["corrugated"] = "corrugated"  # type: ignore[assignment]
    amplitude: float = 0.009
    wavelength: float = 0.076
