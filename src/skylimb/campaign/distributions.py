"""What a campaign's `[vary]` may say of a value: where a number of the unit interval, or a cell, takes it.

A distribution is pure: it maps points of the unit cube to values and draws nothing itself, so that the caller
decides which points are used, and every controller meets the same ones.
"""

from __future__ import annotations

import abc
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import ndtr, ndtri

from skylimb.errors import ConfigError, nearest, unknown_name

KINDS = ("uniform", "log_uniform", "normal", "choice", "grid")

_OPTIONS = {
    "uniform": {"size", "times"},
    "log_uniform": {"size", "times"},
    "normal": {"size", "times", "within"},
    "choice": set(),
    "grid": set(),
}
_TINY = 2.0**-53
"""A point of the unit interval is kept this far from its ends, where a normal quantile is infinite."""


@dataclass(frozen=True)
class Distribution(abc.ABC):
    """How one field of an experiment, or of a controller, varies.

    Attributes:
        size: entries of the value; 0 for a plain number.
        times: a list that one drawn factor scales; empty for the number itself.
    """

    size: int = 0
    times: tuple[float, ...] = ()

    @property
    def dimensions(self) -> int:
        """How many coordinates of the unit cube a value takes."""
        return max(self.size, 1)

    @abc.abstractmethod
    def value(self, point: np.ndarray) -> Any:
        """The value at a point of the unit cube, (dimensions,)."""

    @abc.abstractmethod
    def extremes(self) -> list[Any]:
        """Values at the ends of what can be drawn, to be checked before anything flies."""

    @abc.abstractmethod
    def to_mapping(self) -> dict[str, Any]:
        """The distribution as its table in the TOML file."""

    def _shaped(self, entries: np.ndarray) -> Any:
        if self.times:
            return [float(entries[0]) * entry for entry in self.times]
        return [float(entry) for entry in entries] if self.size else float(entries[0])

    def _repeated(self, number: float) -> Any:
        if self.times:
            return [number * entry for entry in self.times]
        return [number] * self.size if self.size else number

    def _sized(self, table: dict[str, Any]) -> dict[str, Any]:
        if self.times:
            return {**table, "times": list(self.times)}
        return {**table, "size": self.size} if self.size else table


@dataclass(frozen=True)
class Uniform(Distribution):
    """Evenly between two numbers, or evenly in the logarithm."""

    low: float = 0.0
    high: float = 1.0
    logarithmic: bool = False

    def value(self, point: np.ndarray) -> Any:
        """See `Distribution`."""
        if self.logarithmic:
            return self._shaped(np.exp(np.log(self.low) + (np.log(self.high) - np.log(self.low)) * point))
        return self._shaped(self.low + (self.high - self.low) * point)

    def extremes(self) -> list[Any]:
        """See `Distribution`."""
        return [self._repeated(self.low), self._repeated(self.high)]

    def to_mapping(self) -> dict[str, Any]:
        """See `Distribution`."""
        return self._sized({"log_uniform" if self.logarithmic else "uniform": [self.low, self.high]})


@dataclass(frozen=True)
class Normal(Distribution):
    """Normal with a mean and a standard deviation, cut off outside of `low` .. `high`."""

    mean: float = 0.0
    deviation: float = 1.0
    low: float = -np.inf
    high: float = np.inf

    def value(self, point: np.ndarray) -> Any:
        """See `Distribution`."""
        begin, end = (ndtr((bound - self.mean) / self.deviation) for bound in (self.low, self.high))
        share = np.clip(begin + (end - begin) * point, _TINY, 1.0 - _TINY)
        return self._shaped(np.clip(self.mean + self.deviation * ndtri(share), self.low, self.high))

    def extremes(self) -> list[Any]:
        """See `Distribution`; only the mean where nothing is cut off."""
        bounds = [bound for bound in (self.low, self.high) if np.isfinite(bound)]
        return [self._repeated(number) for number in (bounds or [self.mean])]

    def to_mapping(self) -> dict[str, Any]:
        """See `Distribution`."""
        table: dict[str, Any] = {"normal": [self.mean, self.deviation]}
        if np.isfinite(self.low):
            table["within"] = [self.low, self.high]
        return self._sized(table)


@dataclass(frozen=True)
class Choice(Distribution):
    """One of some values, each as likely as the next."""

    values: tuple[Any, ...] = ()

    def value(self, point: np.ndarray) -> Any:
        """See `Distribution`."""
        return self.values[min(int(point[0] * len(self.values)), len(self.values) - 1)]

    def extremes(self) -> list[Any]:
        """See `Distribution`."""
        return list(self.values)

    def to_mapping(self) -> dict[str, Any]:
        """See `Distribution`."""
        return {"choice": list(self.values)}


@dataclass(frozen=True)
class Grid(Choice):
    """All of some values in turn, crossed with everything else."""

    @property
    def dimensions(self) -> int:
        """None: a grid is walked through, not drawn from."""
        return 0

    def to_mapping(self) -> dict[str, Any]:
        """See `Distribution`."""
        return {"grid": list(self.values)}


def distribution(key: str, table: Mapping[str, Any]) -> Distribution:
    """The distribution that a table of `[vary]` describes.

    Args:
        key: dotted key that varies, for messages.
        table: for example {"uniform": [0.1, 0.8]}.

    Raises:
        ConfigError: naming what cannot be used.
    """
    kinds = [name for name in table if name in KINDS]
    if len(kinds) != 1:
        unknown = next((name for name in table if name not in KINDS), None)
        if not kinds and unknown is not None:
            raise unknown_name(f"distribution of vary.'{key}'", unknown, KINDS)
        raise ConfigError(f"vary.'{key}' = {dict(table)!r} must have exactly one of {', '.join(KINDS)}")
    kind = kinds[0]
    for option in table:
        if option != kind and option not in _OPTIONS[kind]:
            raise unknown_name(f"key of vary.'{key}' ({kind})", option, {kind, *_OPTIONS[kind]})
    if kind in ("choice", "grid"):
        values = table[kind]
        if not isinstance(values, list) or not values:
            raise ConfigError(f"vary.'{key}': {kind} = {values!r} must be a list of one or more values")
        return (Grid if kind == "grid" else Choice)(values=tuple(values))
    first, second = _pair(key, kind, table[kind])
    size = table.get("size", 0)
    if not isinstance(size, int) or isinstance(size, bool) or not 0 <= size <= 64:
        raise ConfigError(f"vary.'{key}': size = {size!r} must be a whole number, 1 .. 64")
    times = _factors(key, table, size)
    if kind == "normal":
        if not second > 0.0:
            raise ConfigError(
                f"vary.'{key}': normal = [mean, deviation] needs a positive deviation, not {second:g}"
            )
        low, high = -np.inf, np.inf
        if "within" in table:
            low, high = _ordered(key, "within", *_pair(key, "within", table["within"]))
        return Normal(size, times, first, second, low, high)
    low, high = _ordered(key, kind, first, second)
    if kind == "log_uniform" and not low > 0.0:
        raise ConfigError(f"vary.'{key}': log_uniform = [{low:g}, {high:g}] must be above zero")
    return Uniform(size, times, low, high, kind == "log_uniform")


def is_distribution(table: Any) -> bool:
    """Whether a TOML value is meant as a distribution rather than as a table of further keys."""
    if not isinstance(table, dict):
        return False
    return any(name in KINDS for name in table) or any(
        nearest(name, KINDS) and not isinstance(value, dict) for name, value in table.items()
    )


def _factors(key: str, table: Mapping[str, Any], size: int) -> tuple[float, ...]:
    times = table.get("times", [])
    numbers = isinstance(times, list) and all(
        isinstance(entry, int | float) and not isinstance(entry, bool) and np.isfinite(entry)
        for entry in times
    )
    if not numbers or ("times" in table and not times) or (times and size):
        raise ConfigError(f"vary.'{key}': times = {times!r} must be a list of numbers, and excludes size")
    return tuple(float(entry) for entry in times)


def _pair(key: str, name: str, value: Any) -> tuple[float, float]:
    numbers = isinstance(value, list) and all(
        isinstance(entry, int | float) and not isinstance(entry, bool) and np.isfinite(entry)
        for entry in value
    )
    if not numbers or len(value) != 2:
        raise ConfigError(f"vary.'{key}': {name} = {value!r} must be two finite numbers")
    return float(value[0]), float(value[1])


def _ordered(key: str, name: str, low: float, high: float) -> tuple[float, float]:
    if not low < high:
        raise ConfigError(f"vary.'{key}': {name} = [{low:g}, {high:g}] must go from the lower to the higher")
    return low, high
