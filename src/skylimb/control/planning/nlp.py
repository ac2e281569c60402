"""Nonlinear programmes of plans: IPOPT without a word, and what a search from some start finds."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any, TypeVar

import casadi as ca
import numpy as np

from skylimb.base import interrupts
from skylimb.base.rotations import wrapped

T = TypeVar("T")

_NONE: Mapping[str, Any] = MappingProxyType({})

Found = tuple[float, np.ndarray]
"""Cost and x."""


def ipopt(problem: dict[str, Any], iterations: int, more: Mapping[str, Any] = _NONE) -> ca.Function:
    """IPOPT for a problem as `casadi.nlpsol` takes it, with the derivatives in `more` if given."""
    quiet = {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes", "ipopt.max_iter": iterations}
    return ca.nlpsol("plan", "ipopt", problem, {**quiet, **more})


def search(solver: ca.Function, start: Any, **given: Any) -> Found | None:
    """What a search from a start finds; None without success. Parameters and bounds are named as CasADi's."""
    found, solved = interrupts.search(solver, x0=start, **given)
    return (float(found["f"]), found["x"].full().ravel()) if solved else None


def searches(solver: ca.Function, starts: Iterable[Any], **given: Any) -> list[Found]:
    """What the searches from several starts find, the least cost first."""
    found = (search(solver, start, **given) for start in starts)
    return sorted((one for one in found if one is not None), key=lambda one: one[0])


def distinct(found: Iterable[T], angles: Callable[[T], np.ndarray], apart: float) -> list[T]:
    """Those of which an angle is farther than that from the same one of each before it, rad."""
    kept: list[T] = []
    for one in found:
        if all(np.max(np.abs(wrapped(angles(one) - angles(other))), initial=0.0) > apart for other in kept):
            kept.append(one)
    return kept
