"""Waves: the sinusoidal wall and the corrugated sheet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from skylimb.config import require_range
from skylimb.simulation.surfaces.curved import CurvedSurface
from skylimb.simulation.surfaces.wave import Wave


@dataclass(frozen=True)
class SineWall(CurvedSurface):
    """A wall w = a sin(2 pi u / wavelength + phase), shifted so that `position` lies on it.

    `roll` turns the waves.

    Attributes:
        amplitude: a, m: half of the height from trough to crest.
        wavelength: m.
        phase: rad at u = 0; 0 has the wall recede toward +u there, -pi/2 has the crest that is nearest to
            the robot.
    """

    kind: Literal["sine"] = "sine"
    amplitude: float = 0.1
    wavelength: float = 1.2
    phase: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        require_range("surface", "amplitude", self.amplitude, 0.0, 2.0, "m")
        require_range("surface", "wavelength", self.wavelength, 0.01, 100.0, "m")
        require_range("surface", "phase", self.phase, -6.3, 6.3, "rad")

    def drawn_u(self) -> np.ndarray:
        """Sixteen places a wave."""
        count = int(min(max(121.0, 16.0 * self.size[0] / self.wavelength), 801.0))
        return np.linspace(-0.5, 0.5, count) * self.size[0]

    def make_shape(self) -> Wave:
        """The wave."""
        return Wave(self.amplitude, self.wavelength, self.phase, 0.5 * self.size[0], 0.5 * self.size[1])


@dataclass(frozen=True)
class Corrugated(SineWall):
    """A corrugated sheet: the sine of a roofing sheet, 18 mm deep every 76 mm."""

    kind: Literal["corrugated"] = "corrugated"  # type: ignore[assignment]
    amplitude: float = 0.009
    wavelength: float = 0.076
