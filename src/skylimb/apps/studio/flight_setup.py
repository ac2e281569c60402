"""What flies beside each other: which experiment, which controllers, which values were changed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from skylimb.apps.studio.beside import require_beside
from skylimb.apps.studio.controls import PREFIX
from skylimb.control.controller import Controller
from skylimb.flight.experiments.experiment import Experiment
from skylimb.flight.takeoff import Takeoff, take_off


@dataclass(frozen=True)
class FlightSetup:
    """Everything that a take-off of all flights needs.

    Attributes:
        experiment: a name, a TOML file, or an experiment at hand.
        controllers: one for each flight; None for the experiment's own, or "hybrid" when it has none.
        seed: of the sensors' noise; the experiment's own when None.
        keys: dotted keys of the experiment, and of gains that all flights have, with their new values.
        gains: of each flight, keys of gains and their new values; empty where nobody has changed any.
    """

    experiment: str | Experiment
    controllers: tuple[str | Controller | None, ...]
    seed: int | None = None
    keys: Mapping[str, Any] = field(default_factory=dict)
    gains: tuple[Mapping[str, Any], ...] = ()

    def __post_init__(self) -> None:
        require_beside(self.controllers)

    def with_keys(self, keys: Mapping[str, Any]) -> FlightSetup:
        """The same with some keys of the experiment changed."""
        return replace(self, keys={**self.keys, **keys})

    def with_controllers(self, controllers: Sequence[str | Controller | None]) -> FlightSetup:
        """The same flown by other controllers; one that stays keeps its gains."""
        given = self.gains or ({},) * len(self.controllers)
        left, gains = list(zip(self.controllers, given, strict=True)), list[Mapping[str, Any]]()
        for one in controllers:
            own = next((at for at, (other, _) in enumerate(left) if _same(one, other)), None)
            gains.append({} if own is None else left.pop(own)[1])
        return replace(self, controllers=tuple(controllers), gains=tuple(gains) if any(gains) else ())

    def takeoffs(self) -> list[Takeoff]:
        """One take-off for each controller.

        Raises:
            SkylimbError: when one cannot be flown.
        """
        gains = self.gains or ({},) * len(self.controllers)
        found = []
        for controller, own in zip(self.controllers, gains, strict=True):
            settings = {**self.keys, **{f"{PREFIX}{key}": value for key, value in own.items()}}
            found += take_off(self.experiment, (controller,), self.seed, settings)
        return found


def _same(one: str | Controller | None, other: str | Controller | None) -> bool:
    """Whether two name the same controller; of controllers at hand, whether they are one."""
    return one is other or (isinstance(one, str) and isinstance(other, str) and one == other)
