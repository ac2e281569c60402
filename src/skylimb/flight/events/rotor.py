"""Rotors that give less thrust than they are commanded: one that fails, or all with a battery that sags.

What an engine's rotor makes of its activation is one number, so thrust and drag torque shrink alike, as with
another thrust factor: the rotor's speed stays what its motor makes of the command.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from typing import Annotated, ClassVar, Literal

import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.flight.events.event import Change, Event, EventContext, ModelRows, require_known, write_changes


@configuration
class RotorChange(Event):
    """A rotor's thrust becomes another than commanded; all rotors' changes multiply with each one's own."""

    kind: Literal["rotor"] = field(default="rotor", kw_only=True)
    effectiveness: Annotated[
        float, Key("", "thrust over what is commanded from then on; 0: lost", low=0.0, high=1.5)
    ]
    rotor: Annotated[str, Key("", "which; empty for all, as where a battery sags")] = ""
    duration: Annotated[float, Key("s", "how long the change takes; 0: a jump", low=0.0, high=1e5)] = field(
        default=0.0, kw_only=True
    )

    on: ClassVar[Literal["controller", "plant"]] = "plant"

    @property
    def words(self) -> str:
        """Which rotor, and what is left."""
        return f"{self.rotor or 'all rotors'} to {self.effectiveness:g} of the commanded thrust"

    @property
    def changed(self) -> dict[str, float]:
        """The rotor and what is left."""
        return {self.rotor or "all rotors": self.effectiveness}

    def require(self, context: EventContext) -> None:
        """The robot has such a rotor."""
        names = [rotor.name for rotor in context.robot.description.rotors]
        require_known("rotor of an event", self.rotor, names)

    @classmethod
    def effect(cls, events: Sequence[RotorChange], context: EventContext, times: np.ndarray) -> ModelRows:
        """What each rotor makes of its command, at every tick."""
        assert context.plant is not None
        names = ["", *(rotor.name for rotor in context.robot.description.rotors)]
        left = np.ones((len(times), len(names)))
        for column, name in enumerate(names):
            own = [
                Change(one.time, one.duration, np.ravel(one.effectiveness))
                for one in events
                if one.rotor == name
            ]
            write_changes(left, [column], own, times)
        fields = [("actuator_gainprm", index, 1) for index in range(len(names) - 1)]
        rows = ModelRows.untouched(context.plant.model, fields, times)
        return ModelRows(rows.places, rows.values * left[:, :1] * left[:, 1:])


def thrust_scales(before: np.ndarray, events: ModelRows | None) -> np.ndarray:
    """Thrust that acts over what the lag of each rotor gives, (k, n), or (1, n) where nothing changes it.

    Args:
        before: the same before take-off, (n,).
        events: what the flight's events write into the model.
    """
    scales = before[None]
    places = () if events is None else events.places
    changed = [one for one in places if one.field == "actuator_gainprm" and one.row < len(before)]
    if events is None or not changed:
        return scales
    scales = np.repeat(scales, len(events.values), axis=0)
    for place in changed:
        scales[:, place.row] = events.values[:, place.column]
    return scales
