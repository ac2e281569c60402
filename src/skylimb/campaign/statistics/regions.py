"""Where in the space of what was drawn a controller fails: rules short enough to be read out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

_FEWEST = 5
"""Draws that a region holds at least: fewer make a rule of every outlier."""

_LEAST_GAIN = 0.02
"""Bits a draw that a rule must explain to be worth saying."""

_FEW_VALUES = 6
"""A parameter with at most so many values is told by its values, not by a threshold."""


class Condition(NamedTuple):
    """`parameter < value`, `parameter > value` or `parameter = value`."""

    parameter: str
    sign: str
    value: Any

    def holds(self, values: np.ndarray) -> np.ndarray:
        """Where it holds."""
        if self.sign == "=":
            return values == self.value
        return values < self.value if self.sign == "<" else values > self.value

    def __str__(self) -> str:
        value = f"{self.value:.3g}" if isinstance(self.value, float) else str(self.value)
        return f"{self.parameter} {self.sign} {value}"


class Region(NamedTuple):
    """A part of the space of parameters.

    Attributes:
        conditions: all of them hold in it.
        failed: failures in it.
        count: draws in it.
        failed_outside: failures elsewhere.
        count_outside: draws elsewhere.
    """

    conditions: tuple[Condition, ...]
    failed: int
    count: int
    failed_outside: int
    count_outside: int


def failure_region(parameters: Mapping[str, np.ndarray], failed: np.ndarray) -> Region | None:
    """The region of at most two conditions that tells failures from successes best.

    Best is the gain of information about failing (bits a draw). The first condition is the best alone, the second
    the best within it.

    Args:
        parameters: name -> what was drawn, (n,).
        failed: whether the flight of each draw failed, (n,).

    Returns:
        None where no condition explains anything: no failures, nothing but failures, or failures everywhere.
    """
    inside = np.ones(len(failed), dtype=bool)
    chosen: list[Condition] = []
    reached = 0.0
    for _ in range(2):
        best, gain = _best_condition(parameters, failed, inside)
        if best is None or gain < reached + _LEAST_GAIN:
            break
        inside &= best.holds(parameters[best.parameter])
        chosen.append(best)
        reached = gain
    if not chosen:
        return None
    outside = ~inside
    return Region(
        tuple(chosen), int(failed[inside].sum()), int(inside.sum()), int(failed[outside].sum()), int(outside.sum())
    )


def telling_parameters(parameters: Mapping[str, np.ndarray], failed: np.ndarray) -> list[str]:
    """Parameters by how much one condition on each tells about failing, the most telling first.

    Args:
        parameters: name -> what was drawn, (n,).
        failed: (n, controllers).
    """
    gains = {}
    for name, values in parameters.items():
        every = np.ones(len(values), dtype=bool)
        found = [_best_condition({name: values}, column, every)[1] for column in failed.T]
        gains[name] = sum(found)
    return sorted(gains, key=lambda name: -gains[name])


def _best_condition(
    parameters: Mapping[str, np.ndarray], failed: np.ndarray, within: np.ndarray
) -> tuple[Condition | None, float]:
    best, most = None, 0.0
    for name, values in parameters.items():
        for condition in _conditions(name, values):
            inside = within & condition.holds(values)
            if inside.sum() < _FEWEST or (within & ~inside).sum() < _FEWEST:
                continue
            share, elsewhere = failed[inside].mean(), failed[~inside].mean()
            gain = _information(failed, inside)
            if share > elsewhere and gain > most + 1e-12:
                best, most = condition, gain
    return best, most


def _conditions(name: str, values: np.ndarray) -> Iterator[Condition]:
    distinct = np.unique(values)
    if values.dtype.kind not in "fi" or len(distinct) <= _FEW_VALUES:
        yield from (Condition(name, "=", value.item()) for value in distinct)
    else:
        middles = (distinct[1:] + distinct[:-1]) / 2.0
        for middle in np.quantile(middles, np.linspace(0.0, 1.0, 101)) if len(middles) > 101 else middles:
            yield Condition(name, "<", float(middle))
            yield Condition(name, ">", float(middle))


def _information(failed: np.ndarray, inside: np.ndarray) -> float:
    """Bits a draw that knowing whether a draw lies inside tells about whether it failed."""
    share = inside.mean()
    return _entropy(failed.mean()) - share * _entropy(failed[inside].mean()) - (1.0 - share) * _entropy(
        failed[~inside].mean()
    )  # fmt: skip


def _entropy(share: float) -> float:
    if share <= 0.0 or share >= 1.0:
        return 0.0
    return float(-share * np.log2(share) - (1.0 - share) * np.log2(1.0 - share))
