"""Metrics and figures in a user's own file, usable by name in run, compare, campaign, sweep and tune.

    @skylimb.metric(unit="m", smaller_is_better=True)
    def overshoot(run):
        '''How far the pen went beyond its path.'''
        return float(...)

    @skylimb.figure
    def spring(run):
        '''The pull of the spring over time.'''
        return matplotlib_figure

A metric is a function of a run that returns a number, or, with `keys`, a dict of them. A figure is a function
of a run that returns a matplotlib figure. Neither sees a run that failed.
"""

from __future__ import annotations

import dataclasses
import inspect
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from skylimb.errors import ConfigError, UserCodeError
from skylimb.user_code import UserCode
from skylimb.user_modules import load_module

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

    from skylimb.recording.run import Run


@dataclass(frozen=True)
class Metric:
    """A number that a user computes of a run.

    Attributes:
        name: what it is called in tables; the function's name.
        function: of a run.
        unit: SI, empty for a pure number.
        smaller_is_better: None where neither is; then nobody is ranked by it.
        keys: of the dict that the function returns; empty where it returns a number.
        meaning: the first line of the function's docstring.
    """

    name: str
    function: Callable[[Run], Any]
    unit: str = ""
    smaller_is_better: bool | None = None
    keys: tuple[str, ...] = ()
    meaning: str = ""

    def __call__(self, run: Run) -> Any:
        """What the user's function returns."""
        return self.function(run)

    def description(self, column: str) -> tuple[str, str]:
        """What one of its numbers is, and its unit."""
        key = f", {column.removeprefix(self.name + '_')}" if self.keys else ""
        return (f"{self.meaning}{key}" if self.meaning else column), self.unit or "1"

    @property
    def columns(self) -> tuple[str, ...]:
        """Its names in a table: its own, or its own with each of its keys."""
        return tuple(f"{self.name}_{key}" for key in self.keys) or (self.name,)

    def of(self, run: Run) -> dict[str, float | None]:
        """Its numbers by column; None for a run that failed, and for what is no finite number.

        Raises:
            UserCodeError: when the function fails, or returns something else.
        """
        if run.failed:
            return dict.fromkeys(self.columns)
        what = f"metric '{self.name}'"
        with UserCode(what):
            found = self.function(run)
        if isinstance(found, Mapping) != bool(self.keys) or (self.keys and set(found) != set(self.keys)):
            wanted = f"a dict with {', '.join(self.keys)}" if self.keys else "a number"
            hint = "; name them: @skylimb.metric(keys=(...))" if isinstance(found, Mapping) else ""
            raise UserCodeError(f"{what} should return {wanted}, it returned {found!r}{hint}")
        values = [found[key] for key in self.keys] if self.keys else [found]
        with UserCode(what):
            numbers = [float(value) for value in values]
        return {
            column: number if math.isfinite(number) else None
            for column, number in zip(self.columns, numbers, strict=True)
        }


@dataclass(frozen=True)
class OwnFigure:
    """A figure that a user draws of a run.

    Attributes:
        name: of its file; the function's name.
        function: of a run, to a matplotlib figure.
        caption: the function's docstring.
    """

    name: str
    function: Callable[[Run], Any]
    caption: str = ""

    def __call__(self, run: Run) -> Drawing:
        """The figure.

        Raises:
            UserCodeError: when the function fails, or returns something else.
        """
        what = f"figure '{self.name}'"
        with UserCode(what):
            drawn = self.function(run)
        if not hasattr(drawn, "savefig"):
            raise UserCodeError(
                f"{what} should return a matplotlib figure, it returned {type(drawn).__name__}"
            )
        return drawn


Own = Metric | OwnFigure

KNOWN: dict[str, Metric] = {}
"""The metric of each column, of those that this process has met: for units and goals in tables."""

GOALS: dict[str, float] = {}
"""Columns that say which flight is better: 1 where small is good, -1 where large is."""


def metric(
    function: Callable[[Run], Any] | None = None,
    *,
    unit: str = "",
    smaller_is_better: bool | None = None,
    keys: Sequence[str] = (),
) -> Any:
    """Make a function of a run a `Metric`; see the module."""

    def made(function: Callable[[Run], Any]) -> Metric:
        meaning = (inspect.getdoc(function) or "").partition("\n")[0].rstrip(".")
        found = Metric(function.__name__, function, unit, smaller_is_better, tuple(keys), meaning)
        _meet(found)
        return found

    return made if function is None else made(function)


def figure(function: Callable[[Run], Any]) -> OwnFigure:
    """Make a function of a run an `OwnFigure`; see the module."""
    return OwnFigure(function.__name__, function, " ".join((inspect.getdoc(function) or "").split()))


def _meet(found: Metric) -> None:
    from skylimb.analysis.score_names import NUMERIC_KEYS

    for column in found.columns:
        if column in NUMERIC_KEYS:
            raise ConfigError(f"metric '{column}' has the name of one that ships; choose another")
        KNOWN[column] = found
        GOALS.pop(column, None)
        if found.smaller_is_better is not None:
            GOALS[column] = 1.0 if found.smaller_is_better else -1.0


def load_own(use: Iterable[str | Path | ModuleType | Own]) -> list[Own]:
    """Every metric and figure of some files, modules and functions.

    Args:
        use: Python files by path, modules, and what `metric` and `figure` have made.

    Raises:
        ConfigError: when a file cannot be used, or has neither.
    """
    found: list[Own] = []
    for item in use:
        if isinstance(item, Metric | OwnFigure):
            found.append(item)
            continue
        module = item if isinstance(item, ModuleType) else load_module(Path(item), ())
        here = [value for value in vars(module).values() if isinstance(value, Metric | OwnFigure)]
        if not here:
            raise ConfigError(
                f"'{item}' has no metric and no figure; put @skylimb.metric or @skylimb.figure above one"
            )
        found += here
    for one in found:
        if isinstance(one, Metric):
            _meet(one)
    return found


def metrics_of(own: Iterable[Own]) -> list[Metric]:
    """The metrics among them."""
    return [one for one in own if isinstance(one, Metric)]


def figures_of(own: Iterable[Own]) -> list[OwnFigure]:
    """The figures among them."""
    return [one for one in own if isinstance(one, OwnFigure)]


def own_scores(run: Run, own: Iterable[Own]) -> dict[str, float | None]:
    """The numbers of some metrics, by column."""
    return {name: value for each in metrics_of(own) for name, value in each.of(run).items()}


def with_own_scores(run: Run, own: Iterable[Own]) -> Run:
    """The run with the numbers of some metrics among its own."""
    scores = own_scores(run, own)
    return dataclasses.replace(run, metrics={**run.metrics, **scores}) if scores else run
