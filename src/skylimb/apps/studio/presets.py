"""What keys and gains are as long as nobody changes them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from skylimb.apps.studio.controls import PREFIX
from skylimb.apps.studio.key_edits import Values, values_at_takeoff
from skylimb.apps.studio.live_flights import LiveFlights


class Presets:
    """Remembers, from take-off to take-off, the values of what nobody has changed.

    A controller says some keys of its experiment where nobody else does, and each has gains of its own: so a
    key's preset is its value with the controllers that fly, and a gain's is that of its own controller.

    Args:
        first: keys of the experiment that were given when the studio began; they are no changes.
    """

    def __init__(self, first: Mapping[str, Any]) -> None:
        self._first = first
        self._known: dict[tuple[str, str | None], Any] = {}

    def of(self, live: LiveFlights) -> Values:
        """The presets of all keys of some flights, which have taken off."""
        found = {}
        for (key, number), value in values_at_takeoff(live).items():
            at = key, None if number is None else names_of(live)[number]
            if not self._changed(live, key, number):
                self._known[at] = value
            found[key, number] = self._known.get(at, value)
        return found

    def _changed(self, live: LiveFlights, key: str, number: int | None) -> bool:
        """Whether somebody gave the key another value before these flights took off."""
        setup = live.begun
        if number is not None:
            return bool(setup.gains) and key.removeprefix(PREFIX) in setup.gains[number]
        return key in setup.keys and (key not in self._first or setup.keys[key] != self._first[key])


def names_of(live: LiveFlights) -> list[str]:
    """The names under which the controllers of some flights are offered: as given, else their own."""
    flown = zip(live.begun.controllers, live.flights, strict=True)
    return [one if isinstance(one, str) else flight.takeoff.controller.name for one, flight in flown]
