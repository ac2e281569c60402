"""What `[vary]` may say of a value: how numbers of the unit interval, or cells of a grid, become values.

A distribution draws nothing itself. It maps points of the unit cube to values. The caller chooses the points,
so every controller meets the same values.
"""

from __future__ import annotations

from math import inf
from typing import Annotated, Any

import numpy as np
from scipy.special import ndtr, ndtri

from skylimb.base.keys import Key, RefusedError, configuration, refused

KINDS = ("uniform", "log_uniform", "normal", "choice", "grid")

_OPTIONS = {"within": ("normal",), "size": KINDS[:3], "times": KINDS[:3]}
_TINY = 2.0**-53
"""A point of the unit interval is kept this far from its ends, where a normal quantile is infinite."""


@configuration
class Distribution:
    """How one key of an experiment, or one gain of a controller, varies: one of the first five keys."""

    uniform: Annotated[
        tuple[float, float] | None, Key("", "evenly from one number to another", low=-inf, high=inf)
    ] = None
    log_uniform: Annotated[
        tuple[float, float] | None, Key("", "evenly in the logarithm, between two numbers", above=0, high=inf)
    ] = None
    normal: Annotated[
        tuple[float, float] | None, Key("", "normal: mean and standard deviation", low=-inf, high=inf)
    ] = None
    choice: Annotated[tuple[Any, ...] | None, Key("", "one of these, each as likely as the next")] = None
    grid: Annotated[tuple[Any, ...] | None, Key("", "each of these in turn, crossed with all else")] = None
    within: Annotated[
        tuple[float, float] | None, Key("", "where a normal distribution is cut off", low=-inf, high=inf)
    ] = None
    size: Annotated[int | None, Key("", "entries of the value, each drawn by itself", low=1, high=64)] = None
    times: Annotated[
        tuple[float, ...] | None, Key("", "a list that one drawn factor scales", low=-inf, high=inf)
    ] = None

    def check(self) -> None:
        """Refuse what does not go together."""
        kinds = [name for name in KINDS if getattr(self, name) is not None]
        if len(kinds) != 1:
            key, problem = (kinds[-1], "is one too many") if kinds else ("uniform", "is missing")
            raise RefusedError("Distribution", key, f"{problem}: exactly one of {', '.join(KINDS)} is needed")
        for option, owners in _OPTIONS.items():
            if getattr(self, option) is not None and self.kind not in owners:
                raise refused(self, option, f"does not go with {self.kind}")
        if self.size is not None and self.times is not None:
            raise refused(self, "times", "excludes size")
        for name in (self.kind, "times"):
            if getattr(self, name) == ():
                raise refused(self, name, "must be a list of one or more values")
        if self.normal is not None and not self.normal[1] > 0.0:
            raise refused(self, "normal", "needs a positive standard deviation")
        for name in ("uniform", "log_uniform", "within"):
            ends = getattr(self, name)
            if ends is not None and not ends[0] < ends[1]:
                raise refused(self, name, "must go from the lower to the higher number")

    @property
    def kind(self) -> str:
        """The key that says how values are drawn."""
        return next(name for name in KINDS if getattr(self, name) is not None)

    @property
    def listed(self) -> tuple[Any, ...]:
        """The values of a choice or a grid; empty for numbers that are drawn from a range."""
        return self.choice or self.grid or ()

    @property
    def dimensions(self) -> int:
        """How many coordinates of the unit cube a value takes; none for a grid, which is walked through."""
        return 0 if self.grid else self.size or 1

    def value(self, point: np.ndarray) -> Any:
        """The value at a point of the unit cube, (dimensions,); not for a grid."""
        if self.choice:
            return self.choice[min(int(point[0] * len(self.choice)), len(self.choice) - 1)]
        numbers = self._quantile(point)
        if self.times:
            return [float(numbers[0]) * entry for entry in self.times]
        return [float(number) for number in numbers] if self.size else float(numbers[0])

    def extremes(self) -> list[Any]:
        """Values at the ends of what can be drawn; the mean of a normal distribution without an end."""
        if self.listed:
            return list(self.listed)
        ends = self.uniform or self.log_uniform or self.within or (self.normal or ())[:1]
        if self.times:
            return [[end * entry for entry in self.times] for end in ends]
        return [[end] * self.size for end in ends] if self.size else list(ends)

    def _quantile(self, point: np.ndarray) -> np.ndarray:
        """The number below which the share `point` of all drawn numbers lies."""
        if self.uniform:
            low, high = self.uniform
            return low + (high - low) * point
        if self.log_uniform:
            first, last = (np.log(end) for end in self.log_uniform)
            return np.exp(first + (last - first) * point)
        (mean, deviation), (low, high) = self.normal or (0.0, 1.0), self.within or (-inf, inf)
        begin, end = (ndtr((bound - mean) / deviation) for bound in (low, high))
        share = np.clip(begin + (end - begin) * point, _TINY, 1.0 - _TINY)
        return np.clip(mean + deviation * ndtri(share), low, high)
