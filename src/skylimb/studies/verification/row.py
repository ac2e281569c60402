"""One claim about the contact, what was measured, and what theory says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Row:
    """A verified claim.

    Attributes:
        name: short name, also of its figure.
        claim: what is claimed, in words.
        measured: of the case that is farthest from theory, `unit`.
        theory: of that case; a bound where `bound` says so.
        tolerance: largest deviation allowed, `unit`.
        unit: of the three.
        bound: "" where measured must equal theory to the tolerance; "below" or "above" where it must stay
            on that side of it.
        cases: how many were tried.
        figure: file name of the figure, or None when none was written.
    """

    name: str
    claim: str
    measured: float
    theory: float
    tolerance: float
    unit: str
    bound: str = ""
    cases: int = 1
    figure: str | None = None

    @property
    def deviation(self) -> float:
        """How far measured is from theory, on the wrong side only where theory is a bound."""
        difference = self.measured - self.theory
        if self.bound == "below":
            return max(difference, 0.0)
        if self.bound == "above":
            return max(-difference, 0.0)
        return abs(difference)

    @property
    def passed(self) -> bool:
        """Whether the claim holds; a measurement that is not a number never does."""
        return bool(np.isfinite(self.measured) and self.deviation <= self.tolerance)


@dataclass(frozen=True)
class Evidence:
    """A row and how to draw it.

    Attributes:
        row: the claim.
        draw: draws the evidence on given matplotlib axes.
    """

    row: Row
    draw: Callable[[Any], None] = field(repr=False)


def worst(measured: np.ndarray, theory: np.ndarray | float) -> tuple[float, float]:
    """Measured and theory of the case that deviates most; one that is not a number is the worst of all."""
    measured, theory = np.broadcast_arrays(np.asarray(measured, float), np.asarray(theory, float))
    deviation = np.abs(measured - theory).ravel()
    at = int(np.argmax(np.where(np.isfinite(deviation), deviation, np.inf)))
    return float(measured.ravel()[at]), float(theory.ravel()[at])
