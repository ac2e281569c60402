"""Which gains flew well, so that a flight that absurd ones have lost is one press away from flying again."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from skylimb.apps.studio.changes import settled, settled_gains
from skylimb.apps.studio.live_flight import LiveFlight
from skylimb.apps.studio.live_flights import LiveFlights
from skylimb.flight.events import GainChange

LASTING = 2.0
"""Time for which gains have to fly to count as good, s."""


def good_gains(live: LiveFlights) -> tuple[dict[str, Any], ...] | None:
    """The last gains that flew for `LASTING` and did not lose their flight, as the setup has them.

    Those with which a lost flight ended are not among them, however long they flew.

    Returns:
        The gains that people changed, of each flight; None where one of them has none that flew so long.
    """
    given = live.begun.gains or ({},) * len(live.flights)
    found = []
    for own, flight in zip(given, live.flights, strict=True):
        changed = _last_good(flight)
        if changed is None:
            return None
        found.append({**own, **changed})
    return tuple(found)


def _last_good(flight: LiveFlight) -> dict[str, Any] | None:
    changes = settled(GainChange, flight.experiment, flight.time, flight.first)
    moments = [0.0, *(change.time for change in changes), flight.time]
    spans = list(pairwise(moments))
    lost = flight.over and bool(flight.flight().cause)
    good = [begin for begin, end in (spans[:-1] if lost else spans) if end - begin >= LASTING]
    return settled_gains(flight.experiment, good[-1], flight.first) if good else None
