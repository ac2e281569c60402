"""What flies, in one document: a page shows this and nothing else, whatever it did itself before."""

from __future__ import annotations

import math
from typing import Any

from skylimb.apps.studio.live_flight import LiveFlight
from skylimb.apps.studio.session import Session
from skylimb.apps.studio.surface_edits import surface_now
from skylimb.flight.events import Event


def live_state(session: Session) -> dict[str, Any]:
    """The state of the flights now, ready for JSON.

    Returns:
        `controllers`, by the names under which they are offered; `gains` of each flight that changed since
        take-off, by key; `surface` of the flight that is shown; `push` that is held, or None; `events` of
        the flights; `branches`, `here`, `undo` and `redo` (`Branches.told`); `over` and `verdict`.
    """
    live = session.live
    shown, push = live.shown, session.pushed
    return {
        "controllers": session.flown,
        "gains": [live.gains_now(number) for number in range(len(live.flights))],
        "surface": surface_now(shown.experiment, shown.time),
        "push": push and {"link": push.link, "point": push.point, "force": push.force},
        "events": _events(live.flights),
        "over": live.over,
        "verdict": live.verdict if live.over else [],
        **session.branches.told(),
    }


def next_event(session: Session) -> float:
    """Time at which something happens next that the experiment asks for, s: the state is another then."""
    times = [one.time for flight in session.live.flights for one in flight.experiment.events]
    return min((time for time in times if time > session.live.time), default=math.inf)


def _events(flights: tuple[LiveFlight, ...]) -> list[dict[str, Any]]:
    """What happens to the flights in the order of time; what happens to several is told once."""
    told: dict[tuple[Any, ...], Event] = {}
    for flight in flights:
        for event in flight.experiment.events:
            told.setdefault((event.time, event.kind, event.words), event)
    return [
        {"kind": event.kind, "time": event.time, "duration": event.duration, "words": event.words}
        for _, event in sorted(told.items(), key=lambda item: item[0])
    ]
