"""A campaign as its user writes it: an experiment, controllers, and what varies."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import field, replace
from difflib import SequenceMatcher
from math import inf, prod
from typing import Annotated, Any, Literal

from skylimb.analysis.scores.registry import NUMERIC_KEYS, SCORES, SETS
from skylimb.analysis.scores.score import Score
from skylimb.analysis.scores.user_scores import Metric, load_user_scores, metrics_of
from skylimb.base.config import to_mapping
from skylimb.base.errors import ConfigError, unknown_name
from skylimb.base.keys import Key, RefusedError, configuration, refused
from skylimb.studies.campaign.distributions import Distribution

MOST_DRAWS = 1_000_000


@configuration
class Bound:
    """What a metric must keep for a flight to count as a success."""

    min: Annotated[float | None, Key("", "smallest value of a success", low=-inf, high=inf)] = None
    max: Annotated[float | None, Key("", "largest value of a success", low=-inf, high=inf)] = None

    def check(self) -> None:
        """Refuse a bound without ends, and one that nothing can keep."""
        if self.min is None and self.max is None:
            raise RefusedError("Bound", "min", "or max is missing")
        if self.min is not None and self.max is not None and self.min > self.max:
            raise RefusedError("Bound", "min", f"= {self.min:g} is above max = {self.max:g}")


@configuration
class StopRule:
    """When a campaign has flown enough: when the widest 95 % interval of `until` is at most `width`.

    The intervals are those of every controller's success rate, or of the median paired difference between
    every two controllers (of the median, where there is only one controller).
    """

    until: Annotated[str, Key("", '"success", or a metric')]
    width: Annotated[float, Key("", "narrow enough, in the metric's unit", above=0.0, high=inf)]
    every: Annotated[int, Key("", "draws between two looks", low=1, high=MOST_DRAWS)] = 32
    at_least: Annotated[int, Key("", "draws before the first look", low=2, high=MOST_DRAWS)] = 32


@configuration
class Search:
    """What `skylimb tune` changes, and how long it searches."""

    objective: Annotated[str, Key("", "metric with a direction; its median over the draws is made good")]
    gains: Annotated[
        dict[str, tuple[float, float]],
        Key("", "dotted gain -> smallest and largest; .0, .1 pick an entry of a list", low=-inf, high=inf),
    ]
    trials: Annotated[int, Key("", "sets of gains that each controller flies", low=2, high=100_000)] = 40
    held_out: Annotated[int, Key("", "draws for the verdict, new to the search", low=2, high=MOST_DRAWS)] = 32
    logarithmic: Annotated[bool, Key("", "whether gains are searched in their logarithm")] = True
    spread: Annotated[
        float, Key("", "first standard deviation of the search, in parts of the range", low=0.01, high=1.0)
    ] = 0.2

    def check(self) -> None:
        """Refuse ranges that are none."""
        if not self.gains:
            raise refused(self, "gains", "names no gain")
        need = "0 < low < high (or logarithmic = false)" if self.logarithmic else "low < high"
        for name, (low, high) in self.gains.items():
            if not low < high or (self.logarithmic and not low > 0.0):
                raise RefusedError("Search", "gains", f"'{name}' = [{low:g}, {high:g}] needs {need}")


@configuration
class CampaignSpec:
    """A campaign. All controllers meet the same draws; a lost flight is never a success."""

    experiment: Annotated[str, Key("", "name or TOML file")]
    controllers: Annotated[tuple[str, ...], Key("", "names, TOML files or Python files")]
    draws: Annotated[int, Key("", "draws that each controller flies at most", low=0, high=MOST_DRAWS)] = 0
    seed: Annotated[int, Key("", "of the draws and of the flights' noise", low=0, high=2**32 - 1)] = 0
    sampling: Annotated[
        Literal["sobol", "halton", "random"], Key("", "how points are laid in the unit cube")
    ] = "sobol"
    logs: Annotated[str, Key("", "flights that keep their log: none, failures, worst K, all")] = "failures"
    score: Annotated[str, Key("", "metric with a direction that says which finished flight is worse")] = (
        "error_u_median"
    )
    set: Annotated[dict[str, Any], Key("", "dotted key -> value for all draws")] = field(default_factory=dict)
    only: Annotated[dict[str, tuple[str, ...]], Key("", "varied gain -> controllers that have it")] = field(
        default_factory=dict
    )
    use: Annotated[tuple[str, ...], Key("", "Python files with metrics of your own")] = ()
    calibration: Annotated[
        str, Key("", "a calibration.toml, which every controller knows its robot by; empty for none")
    ] = ""
    measures: Annotated[tuple[str, ...], Key("", "sets of further numbers of each flight")] = ()
    twins: Annotated[
        bool, Key("", "whether a flight with events is measured against the same one without them")
    ] = False
    success: dict[str, Bound] = field(default_factory=dict)
    stop: StopRule | None = None
    tune: Search | None = None
    vary: dict[str, Distribution] = field(default_factory=dict)

    def check(self) -> None:
        """Refuse unknown names, and what does not go together."""
        if not self.controllers:
            raise ConfigError("controllers is empty; `skylimb list` shows the names")
        if not self.draws and not (self.vary and all(entry.grid for entry in self.vary.values())):
            raise ConfigError(
                "draws is 0 or missing; say how many (it may be left out where everything is a grid)"
            )
        log_limit(self.logs)
        sets = {*SETS, *(metric.on_demand for metric in self.user_metrics if metric.on_demand)}
        for name in self.measures:
            if name not in sets:
                raise unknown_name("set of measures", name, sets)
        known = self._declared
        _require_direction("score", self.score, known)
        if self.tune is not None:
            _require_direction("tune.objective", self.tune.objective, known)
        if self.stop is not None:
            _require_known("stop.until", self.stop.until, ("success", *known))
        for name in self.success:
            _require_known("metric of success", name, known)
        for key in self.vary:
            if key in self.set:
                raise ConfigError(f"'{key}' stands both in set and in vary")
        gains = [key for key in self.vary if key.startswith("controller.")]
        for key in self.only:
            if key not in gains:
                raise unknown_name("varied gain in only", key, gains)

    @property
    def keys(self) -> tuple[str, ...]:
        """Every number that a flight's row has."""
        return tuple(self._declared)

    @property
    def scores(self) -> Mapping[str, Score]:
        """The declaration of each of them; the campaign's own `score` ranks, whatever else does."""
        known = self._declared
        return {**known, self.score: replace(known[self.score], ranked=True)}

    @property
    def _declared(self) -> dict[str, Score]:
        measured = (key for name in self.measures for key in SETS.get(name, ()))
        used = (each for each in self.user_metrics if each.on_demand in ("", *self.measures))
        return {
            **{key: SCORES[key] for key in (*NUMERIC_KEYS, *measured)},
            **{score.name: score for each in used for score in each.scores},
        }

    @property
    def user_metrics(self) -> list[Metric]:
        """The metrics of the user's files."""
        return metrics_of(load_user_scores(self.use))

    @property
    def cells(self) -> int:
        """Combinations of all grids; 1 without a grid."""
        return prod(len(entry.grid) for entry in self.vary.values() if entry.grid)

    @property
    def called(self) -> str:
        """What the rate of successes is called: without bounds, every flight that comes to its end is one."""
        return "Success rate" if self.success else "Flown to the end"

    @property
    def aim(self) -> str:
        """What a controller is good at that has many successes, by the same rule."""
        return "succeeding" if self.success else "finishing"

    @property
    def failure(self) -> str:
        """What a flight that is no success is called, by the same rule."""
        return "failure" if self.success else "loss"

    def to_mapping(self) -> dict[str, Any]:
        """The spec as in its file."""
        return {key: value for key, value in to_mapping(self).items() if value not in ({}, [])}


def _require_known(what: str, name: str, known: Collection[str]) -> None:
    """Refuse what is no score of the campaign's flights."""
    if name in known:
        return
    for measures, keys in SETS.items():
        if name in keys:
            raise ConfigError(f"{what} = '{name}' is one of the further numbers: measures = [\"{measures}\"]")
    raise unknown_name(what, name, known)


def _require_direction(what: str, name: str, known: Mapping[str, Score]) -> None:
    """Refuse what is no score of the campaign's flights, or does not say which of them is better."""
    directed = [key for key, score in known.items() if score.directed]
    if name in known and name not in directed:
        directed.sort(key=lambda key: -SequenceMatcher(None, name, key).ratio())
        raise ConfigError(
            f"{what} = '{name}' does not say which flight is better, as neither its small nor its large "
            f"values are; those that do, the nearest name first: {', '.join(directed)}"
        )
    _require_known(what, name, directed)


def log_limit(policy: str) -> int | None:
    """How many of the worst flights a log policy keeps; None for none, failures and all.

    Raises:
        ConfigError: the policy is unknown.
    """
    if policy in ("none", "failures", "all"):
        return None
    match = re.fullmatch(r"worst (\d{1,6})", policy)
    if match is None or int(match[1]) == 0:
        raise ConfigError(
            f"logs = '{policy}' must be none, failures, all, or worst K with a number, as 'worst 10'"
        )
    return int(match[1])
