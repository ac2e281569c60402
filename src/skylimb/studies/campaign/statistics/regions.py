"""Where in the space of what was drawn a controller fails: rules short enough to be read out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.special import xlogy
from scipy.stats import permutation_test

_FEWEST = 5
"""Draws that a region holds at least: fewer make a rule of every outlier."""

CHANCE = 0.01
"""A condition is left out where more than this share of shuffles of the failures have one as good."""

_SHUFFLES = 999

_AT_ONCE = 200_000
"""Numbers of shuffled draws that are looked at together."""

_ROUNDING = 1e-12

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
    best within the region of the first. A condition that chance could have made is left out: one to which
    shuffles of the failures, over all conditions that could have been chosen, have their equals.

    Args:
        parameters: name -> what was drawn, (n,).
        failed: whether the flight of each draw failed, (n,).

    Returns:
        None where no condition explains anything: no failures, nothing but failures, or failures everywhere.
    """
    inside = np.ones(len(failed), dtype=bool)
    chosen: list[Condition] = []
    for _ in range(2):
        tried = [_Tried.of(name, values[inside]) for name, values in parameters.items()]
        best = _best_condition(tried, failed[inside])
        if best is None or not _beyond_chance(tried, failed[inside]):
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
        name: float(np.sum(_most_information([_Tried.of(name, values)], failed.T)))
        for name, values in parameters.items()
    }
    return sorted(gains, key=lambda name: -gains[name])


class _Tried(NamedTuple):
    """The conditions on one parameter, for any failures.

    Attributes:
        conditions: of the parameter that hold for enough draws, and not for all.
        order: of the draws by the parameter.
        begins: where in that order each condition begins to hold.
        ends: where it ends.
    """

    conditions: list[Condition]
    order: np.ndarray
    begins: np.ndarray
    ends: np.ndarray

    @classmethod
    def of(cls, name: str, values: np.ndarray) -> _Tried:
        """All conditions on a parameter of these values, (n,)."""
        order, found = np.argsort(values, kind="stable"), []
        for condition in _conditions(name, values):
            holds = np.flatnonzero(condition.holds(values[order]))
            if _FEWEST <= len(holds) <= len(values) - _FEWEST:
                found.append((condition, holds[0], holds[-1] + 1))
        conditions, begins, ends = zip(*found, strict=True) if found else ((), (), ())
        return cls([*conditions], order, np.array(begins, dtype=int), np.array(ends, dtype=int))

    def information(self, failed: np.ndarray) -> np.ndarray:
        """Bits a draw that each condition tells about failing, 0 where failures are rarer in it.

        Args:
            failed: (..., n).

        Returns:
            (..., conditions).
        """
        counted = np.cumsum(failed[..., self.order], axis=-1)
        counted = np.concatenate([np.zeros_like(counted[..., :1]), counted], axis=-1)
        total, n = counted[..., -1:], failed.shape[-1]
        there, draws = counted[..., self.ends] - counted[..., self.begins], self.ends - self.begins
        counts = np.arange(n + 1)
        x = xlogy(counts, counts)
        # Entropies by counts: of both, less those of the two columns and of the two rows of their table.
        told = x[there] + x[draws - there] + x[total - there] + x[n - draws - total + there] + x[n]
        told = (told - x[draws] - x[n - draws] - x[total] - x[n - total]) / (n * np.log(2.0))
        return np.where(there * n > total * draws, told, 0.0)


def _best_condition(tried: Sequence[_Tried], failed: np.ndarray) -> Condition | None:
    """The condition that tells most about failing; None where none tells anything."""
    conditions = [condition for one in tried for condition in one.conditions]
    if not conditions:
        return None
    told = np.concatenate([one.information(failed) for one in tried])
    # The first of those that are as good but for rounding.
    return (
        conditions[int(np.argmax(told > told.max() - _ROUNDING))]
        if told.max(initial=0.0) > _ROUNDING
        else None
    )


def _most_information(tried: Sequence[_Tried], failed: np.ndarray) -> np.ndarray:
    """Bits a draw that the best of all conditions tells about failures, (..., n)."""
    return np.max([one.information(failed).max(axis=-1, initial=0.0) for one in tried], axis=0)


def _beyond_chance(tried: Sequence[_Tried], failed: np.ndarray) -> bool:
    """Whether few shuffles of the failures have a condition as good as the best one of the failures."""

    def told(shuffled: np.ndarray, axis: int) -> np.ndarray:
        return _most_information(tried, np.moveaxis(shuffled, axis, -1))

    result: Any = permutation_test(
        (failed,),
        told,
        permutation_type="pairings",
        vectorized=True,
        n_resamples=_SHUFFLES,
        batch=max(1, _AT_ONCE // len(failed)),
        alternative="greater",
        rng=np.random.default_rng(0),
    )
    return float(result.pvalue) <= CHANCE


def _conditions(name: str, values: np.ndarray) -> Iterator[Condition]:
    distinct = np.unique(values)
    if values.dtype.kind not in "fi" or len(distinct) <= _FEW_VALUES:
        yield from (Condition(name, "=", value.item()) for value in distinct)
    else:
        middles = (distinct[1:] + distinct[:-1]) / 2.0
        for middle in np.quantile(middles, np.linspace(0.0, 1.0, 101)) if len(middles) > 101 else middles:
            yield Condition(name, "<", float(middle))
            yield Condition(name, ">", float(middle))
