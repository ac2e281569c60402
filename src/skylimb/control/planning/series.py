"""Short series for smooth functions of one variable: one harmonic where exact, else Chebyshev polynomials."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from skylimb.base.errors import UnreachableError
from skylimb.symbolic import clip, is_symbolic

_EXACT = 1e-12
_SLACK = 1e-9
"""A rounding error beyond the end of a range is inside of it."""


def within(given: Any, ends: tuple[float, float], what: str, unit: str, limits: str) -> Any:
    """A number or an array, refused where it is outside of a range; a symbol, which cannot be, held inside.

    Args:
        given: the variable.
        ends: of its range.
        what: it is, for the message, with braces in the place of its value.
        unit: its own.
        limits: what ends the range, in words.

    Raises:
        UnreachableError: a number outside of the range.
    """
    low, high = ends
    if is_symbolic(given):
        return clip(given, low, high)
    value = np.asarray(given, dtype=float)
    inside = (value >= low - _SLACK) & (value <= high + _SLACK)
    if not np.all(inside):
        named = what.format(f"{float(np.ravel(value[~inside])[0]):.4g} {unit}")
        raise UnreachableError(f"{named} is outside of {low:.4g} .. {high:.4g} {unit} ({limits})")
    return value if value.ndim else float(value)


def fit_circle(
    function: Callable[[float], float], low: float, high: float
) -> tuple[float, float, float] | None:
    """(A, B, C) with function = A + B cos + C sin over the range, or None where that is not exact."""
    grid = np.linspace(low, high, 33)
    values = np.array([function(theta) for theta in grid])
    basis = np.column_stack([np.ones_like(grid), np.cos(grid), np.sin(grid)])
    found = np.linalg.lstsq(basis, values, rcond=None)[0]
    if np.max(np.abs(basis @ found - values)) > _EXACT * max(1.0, np.max(np.abs(values))):
        return None
    # A coefficient of rounding size would cost operations at every tick for nothing.
    A, B, C = (float(entry) if abs(entry) > _EXACT else 0.0 for entry in found)
    return A, B, C


def fit_chebyshev(function: Callable[[float], float], low: float, high: float) -> np.ndarray:
    """Chebyshev coefficients of a smooth function on a range, of the degree that its smoothness asks for."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    for degree in (8, 16, 32, 64):
        x = chebyshev.chebpts1(degree + 1)
        found = chebyshev.chebfit(x, [function(middle + half * at) for at in x], degree)
        if np.max(np.abs(found[-2:])) < 1e-11:
            break
    return found


def evaluate_chebyshev(coefficients: np.ndarray, low: float, high: float, value: Any) -> Any:
    """A Chebyshev series on a range by Clenshaw's recurrence, on numbers or symbols."""
    x = (2.0 * value - (low + high)) / (high - low)
    later, last = 0.0, 0.0
    for coefficient in coefficients[:0:-1]:
        later, last = coefficient + 2.0 * x * later - last, later
    return coefficients[0] + x * later - last
