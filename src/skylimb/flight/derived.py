"""What is computed of a flight's plan, kept by what it was computed from."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from skylimb.base.keys import is_configuration

T = TypeVar("T")

_KEPT = 4
"""Results of one function that are kept: a live flight goes to and fro between a few plans."""


class Derived:
    """Results of pure functions by their inputs.

    A plan that differs from another in one value shares all that does not depend on it: nothing is patched,
    and nothing can be left over that belongs to other inputs.
    """

    def __init__(self) -> None:
        self._kept: dict[Callable[..., Any], list[tuple[tuple[Any, ...], Any]]] = {}

    def of(self, function: Callable[..., T], *inputs: Any) -> T:
        """The function's result for these inputs, computed where it is not known yet."""
        kept = self._kept.setdefault(function, [])
        for known, result in kept:
            if len(known) == len(inputs) and all(map(_same, known, inputs)):
                return result
        result = function(*inputs)
        kept.append((inputs, result))
        del kept[:-_KEPT]
        return result


def _same(one: Any, other: Any) -> bool:
    """Whether two inputs are one object, or equal values; robots and arrays are compared as objects."""
    if one is other:
        return True
    if type(one) is not type(other):
        return False
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(_same, one, other))
    return (isinstance(one, str | int | float) or is_configuration(type(one))) and bool(one == other)
