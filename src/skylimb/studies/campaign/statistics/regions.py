"""Where in the space of what was drawn a controller fails: rules short enough to be read out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from scipy.special import entr
from scipy.stats import fisher_exact

_FEWEST = 5
"""Draws that a region holds at least: fewer make a rule of every outlier."""

_CHANCE = 1e-3
"""A condition that a shuffle of the failures would give as often as this is left out (Fisher's exact test).

It is small because many conditions are tried.
"""

_FEW_VALUES = 6
"""A parameter with at most so many values gets a condition on its values, not a threshold."""


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
        draws: draws in it.
        failed_outside: failures elsewhere.
        draws_outside: draws elsewhere.
    """

    conditions: tuple[Condition, ...]
    failed: int
    draws: int
    failed_outside: int
    draws_outside: int


def failure_region(parameters: Mapping[str, np.ndarray], failed: np.ndarray) -> Region | None:
    """The region of at most two conditions that tells failures from successes best.

    Best is the gain of information about failing. The first condition is the best alone, the second the
    best within the region of the first. A condition that chance could have made is left out.

    Args:
        parameters: name -> what was drawn, (n,).
        failed: whether the flight of each draw failed, (n,).

    Returns:
        None where no condition explains anything: no failures, nothing but failures, or failures everywhere.
    """
    inside = np.ones(len(failed), dtype=bool)
    chosen: list[Condition] = []
    for _ in range(2):
        there = {name: values[inside] for name, values in parameters.items()}
        best, _ = _best_condition(there, failed[inside])
        if best is None or not _beyond_chance(failed[inside], best.holds(there[best.parameter])):
            break
        inside &= best.holds(parameters[best.parameter])
        # A bound that a tighter one follows says nothing more.
        chosen = [one for one in chosen if (one.parameter, one.sign) != (best.parameter, best.sign)] + [best]
    if not chosen:
        return None
    outside = ~inside
    return Region(
        tuple(chosen),
        int(failed[inside].sum()),
        int(inside.sum()),
        int(failed[outside].sum()),
        int(outside.sum()),
    )


def parameters_by_information(parameters: Mapping[str, np.ndarray], failed: np.ndarray) -> list[str]:
    """Parameters by how much one condition on each says about failing, the most informative first.

    Args:
        parameters: name -> what was drawn, (n,).
        failed: (n, controllers).
    """
    gains = {
        name: sum(_best_condition({name: values}, column)[1] for column in failed.T)
        for name, values in parameters.items()
    }
    return sorted(gains, key=lambda name: -gains[name])


def _best_condition(
    parameters: Mapping[str, np.ndarray], failed: np.ndarray
) -> tuple[Condition | None, float]:
    """The condition that tells most about failing, and how many bits a draw it tells."""
    best, most = None, 0.0
    for name, values in parameters.items():
        for condition in _conditions(name, values):
            inside = condition.holds(values)
            if not _FEWEST <= inside.sum() <= len(failed) - _FEWEST:
                continue
            gain = _information(failed, inside)
            if failed[inside].mean() > failed[~inside].mean() and gain > most + 1e-12:
                best, most = condition, gain
    return best, most


def _beyond_chance(failed: np.ndarray, inside: np.ndarray) -> bool:
    table = [
        [np.sum(failed & inside), np.sum(~failed & inside)],
        [np.sum(failed & ~inside), np.sum(~failed & ~inside)],
    ]
    result: Any = fisher_exact(np.array(table), "greater")
    return float(result.pvalue) <= _CHANCE


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
    return float(entr([share, 1.0 - share]).sum() / np.log(2.0))
