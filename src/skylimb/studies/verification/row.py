"""One claim about the contact, what was measured, and what theory says."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike


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


def evidence(
    name: str,
    claim: str,
    measured: ArrayLike,
    theory: ArrayLike,
    tolerance: float,
    unit: str,
    draw: Callable[[Any], None],
    *,
    bound: str = "",
    cases: int | None = None,
) -> Evidence:
    """The row of all cases of a claim, judged by the one that is farthest from theory, and its figure.

    Args:
        name: as in `Row`, as are claim, tolerance, unit and bound.
        claim: in words.
        measured: of every case.
        theory: of every case, or of all.
        tolerance: largest deviation allowed.
        unit: of the three.
        draw: draws the evidence on given matplotlib axes.
        bound: where theory is a bound; the largest case then counts, or the smallest.
        cases: how many; as many as measured by default.
    """
    values = np.asarray(measured, dtype=float)
    farthest, expected = worst(values, theory)
    if bound:
        farthest = float(values.max() if bound == "below" else values.min())
    count = values.size if cases is None else cases
    return Evidence(Row(name, claim, farthest, expected, tolerance, unit, bound, count), draw)


def sweep(measure: Callable[..., Any], *axes: Sequence[Any] | np.ndarray) -> np.ndarray:
    """What is measured at every combination of values, with a dimension for each axis, then the result's."""
    found = np.array([measure(*case) for case in itertools.product(*axes)])
    return found.reshape(*map(len, axes), *found.shape[1:])


def worst(measured: ArrayLike, theory: ArrayLike) -> tuple[float, float]:
    """Measured and theory of the case that deviates most; one that is not a number is the worst of all."""
    measured, theory = np.broadcast_arrays(np.asarray(measured, float), np.asarray(theory, float))
    deviation = np.abs(measured - theory).ravel()
    at = int(np.argmax(np.where(np.isfinite(deviation), deviation, np.inf)))
    return float(measured.ravel()[at]), float(theory.ravel()[at])
