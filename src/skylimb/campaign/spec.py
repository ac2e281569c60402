"""A campaign as its user writes it: one TOML file with an experiment, controllers and what varies."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any, Literal

from skylimb.analysis.measures import SETS
from skylimb.analysis.metrics import NUMERIC_KEYS
from skylimb.campaign.distributions import Distribution, Grid
from skylimb.config import require_positive, require_range, to_mapping
from skylimb.errors import ConfigError, unknown_name

FROZEN = "frozen"
"""The table that a campaign's folder adds to its copy of the spec; see `skylimb.campaign.frozen`."""

MOST_DRAWS = 1_000_000

GOALS = {
    "error_y_median": 1.0,
    "error_z_median": 1.0,
    "displacement_x_median": 1.0,
    "contact_force_normal_std": 1.0,
    "contact_force_normal_peak": 1.0,
    "contact_fraction": -1.0,
    "tilt_max": 1.0,
}
"""Metrics that say which flight is better: 1 where small is good, -1 where large is."""


@dataclass(frozen=True)
class Bound:
    """What a metric must keep for a flight to count as a success."""

    min: float | None = None
    max: float | None = None

    def __post_init__(self) -> None:
        if self.min is None and self.max is None:
            raise ConfigError("success needs min, max or both")


@dataclass(frozen=True)
class StopRule:
    """When a campaign has flown enough.

    Attributes:
        until: "success", or a metric; its widest 95 % interval is looked at: of a controller's success
            rate, or of the median paired difference between two controllers (of the median, where there is
            only one).
        width: the interval is narrow enough at this width, in the metric's unit.
        every: draws between two looks.
        at_least: draws before the first look.
    """

    until: str
    width: float
    every: int = 32
    at_least: int = 32

    def __post_init__(self) -> None:
        if self.until != "success" and self.until not in NUMERIC_KEYS:
            raise unknown_name("stop.until", self.until, ["success", *NUMERIC_KEYS])
        require_positive("stop", "width", self.width)
        require_range("stop", "every", self.every, 1, MOST_DRAWS)
        require_range("stop", "at_least", self.at_least, 2, MOST_DRAWS)


@dataclass(frozen=True)
class Search:
    """What `skylimb tune` changes, and how long it looks.

    Attributes:
        objective: metric whose median over the draws is made small (or large, where large is good).
        gains: dotted gain of the controller -> [low, high]; `.0`, `.1` pick an entry of a list.
        trials: sets of gains that are flown for each controller.
        held_out: draws for the verdict, none of which the search has seen.
        logarithmic: whether gains are searched in their logarithm.
        spread: first standard deviation of the search, in parts of the range.
    """

    objective: str
    gains: dict[str, tuple[float, float]]
    trials: int = 40
    held_out: int = 32
    logarithmic: bool = True
    spread: float = 0.2

    def __post_init__(self) -> None:
        if self.objective not in GOALS:
            raise unknown_name("tune.objective", self.objective, GOALS)
        if not self.gains:
            raise ConfigError("tune.gains names no gain")
        for name, (low, high) in self.gains.items():
            if not low < high or (self.logarithmic and not low > 0.0):
                need = "0 < low < high (or logarithmic = false)" if self.logarithmic else "low < high"
                raise ConfigError(f"tune.gains.'{name}' = [{low:g}, {high:g}] needs {need}")
        require_range("tune", "trials", self.trials, 2, 100_000)
        require_range("tune", "held_out", self.held_out, 2, MOST_DRAWS)
        require_range("tune", "spread", self.spread, 0.01, 1.0)


@dataclass(frozen=True)
class PlainSpec:
    """All of a spec that maps onto fields as it stands."""

    experiment: str
    controllers: tuple[str, ...]
    draws: int = 0
    seed: int = 0
    sampling: Literal["sobol", "halton", "random"] = "sobol"
    logs: str = "failures"
    score: str = "error_y_median"
    set: dict[str, Any] = field(default_factory=dict)
    only: dict[str, tuple[str, ...]] = field(default_factory=dict)
    measures: tuple[str, ...] = ()
    success: dict[str, Bound] = field(default_factory=dict)
    stop: StopRule | None = None
    tune: Search | None = None

    def __post_init__(self) -> None:
        if not self.controllers:
            raise ConfigError("controllers is empty; `skylimb list` shows the names")
        require_range("", "draws", self.draws, 0, MOST_DRAWS)
        require_range("", "seed", self.seed, 0, 2**32 - 1)
        log_limit(self.logs)
        if self.score not in GOALS:
            raise unknown_name("score", self.score, GOALS)
        for name in self.measures:
            if name not in SETS:
                raise unknown_name("set of measures", name, SETS)
        for name in self.success:
            if name not in NUMERIC_KEYS:
                raise unknown_name("metric of success", name, NUMERIC_KEYS)


@dataclass(frozen=True)
class CampaignSpec(PlainSpec):
    """A campaign.

    Attributes:
        experiment: name or TOML file.
        controllers: names, TOML files or Python files; all meet the same draws.
        draws: how many draws each controller flies at most; by default every cell of the grid once.
        seed: of the draws and of the flights' noise.
        sampling: how the points are laid: two low-discrepancy sequences, or independently.
        logs: which flights keep their log: none, failures, worst K, all.
        score: metric that says which of two finished flights is the worse.
        set: dotted keys that are changed for all draws.
        only: varied gain -> names of the controllers that have it; every other gain is everyone's.
        measures: further numbers of each flight, sets of `skylimb.analysis.measures.SETS`.
        success: metric -> what it must keep; a lost flight is never a success.
        stop: when to stop before `draws`.
        tune: what `skylimb tune` searches.
        vary: dotted key -> distribution. Keys that begin with "controller." are gains of every controller.
    """

    vary: dict[str, Distribution] = field(default_factory=dict)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.draws < 1:
            raise ConfigError("the key 'draws' is missing (it may be left out where everything is a grid)")

    @property
    def keys(self) -> tuple[str, ...]:
        """Every number that a flight's row has."""
        return (*NUMERIC_KEYS, *(key for name in self.measures for key in SETS[name].keys))

    @property
    def cells(self) -> int:
        """Combinations of all grids; 1 without a grid."""
        count = 1
        for entry in self.vary.values():
            count *= len(entry.values) if isinstance(entry, Grid) else 1
        return count

    def to_mapping(self) -> dict[str, Any]:
        """The spec as in its file."""
        table = to_mapping(_plain(self))
        for name in ("set", "only", "measures", "success"):
            if not table[name]:
                del table[name]
        return {**table, "vary": {key: entry.to_mapping() for key, entry in self.vary.items()}}


def log_limit(policy: str) -> int | None:
    """How many of the worst flights a log policy keeps; None for none, failures and all.

    Raises:
        ConfigError: when the policy is none of those known.
    """
    if policy in ("none", "failures", "all"):
        return None
    match = re.fullmatch(r"worst (\d{1,6})", policy)
    if match is None or int(match[1]) == 0:
        raise ConfigError(
            f"logs = '{policy}' must be none, failures, all, or worst K with a number, as 'worst 10'"
        )
    return int(match[1])


def _plain(spec: CampaignSpec) -> dict[str, Any]:
    return {name: getattr(spec, name) for name in PlainSpec.__dataclass_fields__}
