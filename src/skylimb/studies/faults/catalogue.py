"""The catalogue: every fault as data, and what it is held to."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import field, replace
from math import inf
from pathlib import Path
from typing import Annotated, Any

from skylimb.analysis.scores.registry import SETS
from skylimb.base.config import from_mapping, read_toml
from skylimb.base.errors import ConfigError, unknown_name
from skylimb.base.keys import Key, configuration
from skylimb.studies.campaign.distributions import Distribution
from skylimb.studies.campaign.spec import CampaignSpec

CATALOGUE = Path(__file__).with_name("catalogue.toml")
MEASURES = "faults"
"""The set of a flight's numbers that bounds may name, without "fault_" before them."""
NOTICED = ("seen", "believed", "alarms")
"""Those that a flight without a supervisor does not have."""
SWITCH = "supervisor.on"
"""Key of an experiment whose flights are supervised."""


@configuration
class Fault:
    """A fault, what it does by physics, and what a flight must keep."""

    name: Annotated[str, Key("", "short name; of its folder too")]
    physics: Annotated[str, Key("", "what happens, and what is possible at best")]
    set: Annotated[dict[str, Any], Key("", "dotted key -> value; its events among them")] = field(
        default_factory=dict
    )
    vary: dict[str, Distribution] = field(default_factory=dict)
    survived: Annotated[bool, Key("", "whether it is to be outlived; where not, it is to be noticed")] = True
    bounds: Annotated[
        dict[str, tuple[float, float]],
        Key("", "number of a flight -> greatest median, and what 99 % keep", low=-inf, high=inf),
    ] = field(default_factory=dict)

    def held(self, supervised: bool) -> dict[str, tuple[float, float]]:
        """The bounds of a flight; only a supervised one notices anything."""
        return {key: bound for key, bound in self.bounds.items() if supervised or key not in NOTICED}

    def check(self) -> None:
        """Refuse a bound of something that is not measured."""
        known = [key.removeprefix("fault_") for key in SETS[MEASURES]]
        for key in self.bounds:
            if key not in known:
                raise unknown_name(f"bound of fault '{self.name}'", key, known)


@configuration
class Catalogue:
    """Faults, and the flights that meet them."""

    experiment: Annotated[str, Key("", "name or TOML file")]
    controllers: Annotated[tuple[str, ...], Key("", "that meet every fault")]
    faults: tuple[Fault, ...]
    seed: Annotated[int, Key("", "of the draws and of the flights' noise", low=0, high=2**32 - 1)] = 0
    set: Annotated[dict[str, Any], Key("", "dotted key -> value for all flights")] = field(
        default_factory=dict
    )
    supervised: Annotated[dict[str, Any], Key("", "the same for the supervised ones")] = field(
        default_factory=lambda: {SWITCH: True}
    )
    vary: dict[str, Distribution] = field(default_factory=dict)

    def check(self) -> None:
        """Refuse two faults of one name."""
        names = [fault.name for fault in self.faults]
        for name in names:
            if names.count(name) > 1:
                raise ConfigError(f"two faults of the catalogue are called '{name}'")

    def only(self, names: Collection[str], controllers: Sequence[str]) -> Catalogue:
        """The same with some of its faults and other controllers; none named leaves what there is."""
        known = [fault.name for fault in self.faults]
        for name in names:
            if name not in known:
                raise unknown_name("fault", name, known)
        faults = tuple(fault for fault in self.faults if not names or fault.name in names)
        return replace(self, faults=faults, controllers=tuple(controllers) or self.controllers)

    def campaign(self, fault: Fault, draws: int, supervised: bool) -> CampaignSpec:
        """A fault as a campaign.

        Args:
            fault: of this catalogue.
            draws: that each controller flies.
            supervised: whether the supervisor is on.
        """
        return CampaignSpec(
            experiment=self.experiment,
            controllers=self.controllers,
            draws=draws,
            seed=self.seed,
            set={SWITCH: False, **self.set, **fault.set, **(self.supervised if supervised else {})},
            vary={**self.vary, **fault.vary},
            measures=(MEASURES,),
            twins="tip" in fault.bounds,
            score="fault_tilt",
            logs=f"worst {len(self.controllers)}",
        )


def load_catalogue(path: str | Path = CATALOGUE) -> Catalogue:
    """Read a catalogue.

    Raises:
        ConfigError: naming the key that is unknown, missing or of the wrong kind.
    """
    return from_mapping(Catalogue, read_toml(path), f"catalogue {Path(path).name}")
