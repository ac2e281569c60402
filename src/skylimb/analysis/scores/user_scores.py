"""Metrics and figures in a user's own file, usable by name in run, compare, campaign, sweep and tune.

    @skylimb.metric(unit="m", smaller_is_better=True)
    def overshoot(run):
        '''How far the pen went beyond its path.'''
        return float(...)

    @skylimb.figure
    def spring(run):
        '''The pull of the spring over time.'''
        return matplotlib_figure

What a metric is stands in `skylimb.analysis.scores.score`. A figure is a function of a run that returns a
matplotlib figure. Neither sees a run that failed.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from skylimb.analysis.recording.run import NOTES, PROBLEMS, AnyRun, Run
from skylimb.analysis.scores.declared import declared_in, declaring
from skylimb.analysis.scores.metrics import metrics
from skylimb.analysis.scores.read_only import read_only
from skylimb.analysis.scores.registry import SCORES, TOLERANCES
from skylimb.analysis.scores.score import Metric, Number
from skylimb.analysis.scores.verdict import verdict
from skylimb.base.errors import ConfigError, UserCodeError, unknown_name
from skylimb.base.plugins import added_file
from skylimb.base.user_code import UserCode
from skylimb.base.user_modules import load_module

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

TAKEN = frozenset(
    {*SCORES, "status", "cause", "missed", "checks", "force_limits", "strokes", "success", PROBLEMS, NOTES}
)
"""What a metric cannot be called."""


@dataclass(frozen=True)
class UserFigure:
    """A figure that a user draws of a run.

    Attributes:
        name: of its file; the function's name.
        function: of a run, to a matplotlib figure.
        caption: the function's docstring.
    """

    name: str
    function: Callable[[Any], Any]
    caption: str = ""

    def __call__(self, run: Run) -> Drawing:
        """The figure.

        Raises:
            UserCodeError: when the function fails, or returns something else.
        """
        what = f"figure '{self.name}'"
        with UserCode(what):
            drawn = self.function(read_only(run))
        if not hasattr(drawn, "savefig"):
            raise UserCodeError(
                f"{what} should return a matplotlib figure, it returned {type(drawn).__name__}"
            )
        return drawn


UserScore = Metric | UserFigure


def figure(function: Callable[[Any], Any]) -> UserFigure:
    """Make a function of a run an `UserFigure`; see the module."""
    return UserFigure(function.__name__, function, " ".join((inspect.getdoc(function) or "").split()))


def load_user_scores(use: Iterable[str | Path | ModuleType | UserScore]) -> list[UserScore]:
    """Every metric and figure of some files, modules and functions.

    Args:
        use: Python files by path, or by the name under which an installed package adds them; modules; and
            what `metric` and `figure` have made.

    Raises:
        ConfigError: when a file cannot be used, has neither, or has a metric that cannot be one.
    """
    if isinstance(use, str | Path):
        raise ConfigError(f"use = '{use}' should be a list, as in use=['{use}']")
    found: list[UserScore] = []
    for item in use:
        if isinstance(item, Metric | UserFigure):
            found.append(item)
            continue
        if not isinstance(item, str | Path | ModuleType):
            name = getattr(item, "__name__", repr(item))
            raise ConfigError(
                f"use: '{name}' is neither a Python file nor a metric or figure; put @skylimb.metric or "
                "@skylimb.figure above it"
            )
        module = item if isinstance(item, ModuleType) else load_module(metric_file(item), ())
        here = [value for value in vars(module).values() if isinstance(value, Metric | UserFigure)]
        if not here:
            raise ConfigError(
                f"'{item}' has no metric and no figure; put @skylimb.metric or @skylimb.figure above one"
            )
        found += here
    for each in metrics_of(found):
        _check(each)
    return found


def metric_file(named: str | Path) -> Path:
    """The file of metrics that is meant: an installed package's by its name, else the path itself."""
    return added_file("metrics", str(named), ships=False) or Path(named)


def _check(metric: Metric) -> None:
    """Refuse a name that is taken, and a tolerance that no experiment has."""
    for score in metric.scores:
        if score.name in TAKEN:
            raise ConfigError(f"metric '{score.name}' has the name of one that ships; choose another")
        bound = score.tolerance.bound if score.tolerance else None
        if isinstance(bound, str) and bound not in TOLERANCES:
            raise unknown_name(f"tolerance of metric '{score.name}'", bound, TOLERANCES)


def metrics_of(own: Iterable[UserScore]) -> list[Metric]:
    """The metrics among them."""
    return [one for one in own if isinstance(one, Metric)]


def figures_of(own: Iterable[UserScore]) -> list[UserFigure]:
    """The figures among them."""
    return [one for one in own if isinstance(one, UserFigure)]


def scored(run: AnyRun, own: Iterable[UserScore] = (), sets: Iterable[str] = ()) -> AnyRun:
    """The run with its scores and its verdict; every record is scored here, a fresh one or an old one.

    A user's metric that fails loses its own numbers and nothing else: they are None, and `Run.problems` says
    why. Numbers of metrics that are not among `own` stay as the record has them, and are judged again.

    Args:
        run: a flight.
        own: metrics of the user's; figures among them are passed over.
        sets: those with a set (`on_demand`) are computed where it is among these.
    """
    used = [each for each in metrics_of(own) if each.on_demand in {"", *sets}]
    declared = declared_in(run.log)
    numbers: dict[str, Number] = {name: run.metrics.get(name) for name in declared}
    numbers |= dict.fromkeys(key for each in used for key in each.columns)
    anew = {_metric(each) for each in used}
    problems = {name: why for name, why in run.problems.items() if name not in anew}
    fresh = replace(run, metrics=metrics(run.log))
    for each in used if not run.failed else ():
        try:
            with UserCode(_metric(each)):
                values = each.values(read_only(fresh))
                numbers |= each.numbers(values)
                for name, value in zip(each.columns, values, strict=True):
                    if np.isinf(float(value)):
                        said = f"{_metric(each)} returned {float(value):g} as {name}"
                        raise UserCodeError(f"{said}; expected a finite number, or NaN where there is none")
        except UserCodeError as error:
            problems[_metric(each)] = str(error)
    judged = {**declared, **{score.name: score for each in used for score in each.scores}}.values()
    if judged:
        fresh = replace(fresh, metrics={**fresh.metrics, **numbers})
        fresh = declaring(replace(fresh, metrics={**fresh.metrics, **verdict(fresh, judged)}), judged)
    return replace(fresh, metrics={**fresh.metrics, PROBLEMS: problems}) if problems else fresh


def _metric(metric: Metric) -> str:
    return f"metric '{metric.name}'"
