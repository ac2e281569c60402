"""What an eigenvalue of a closed loop says."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Mode:
    """An eigenvalue, or a pair of them, of the map over one control period.

    Attributes:
        eigenvalue: the one with a positive imaginary part.
        period: of control, s.
        parts: the states that take part, largest share first; shares of all states add up to 1.
    """

    eigenvalue: complex
    period: float
    parts: tuple[tuple[str, float], ...]

    @property
    def rate(self) -> complex:
        """ln(eigenvalue) / period, 1/s: the same mode in continuous time."""
        size = max(abs(self.eigenvalue), 1e-300)
        return complex(math.log(size), math.atan2(self.eigenvalue.imag, self.eigenvalue.real)) / self.period

    @property
    def growth(self) -> float:
        """At which it grows, 1/s; negative when it dies away."""
        return self.rate.real

    @property
    def frequency(self) -> float:
        """Hz."""
        return abs(self.rate.imag) / (2.0 * math.pi)

    @property
    def damping_ratio(self) -> float:
        """1 is no swing, 0 no end of it, below 0 it grows."""
        return -self.rate.real / max(abs(self.rate), 1e-300)
