"""What flies, in one document: a page shows this and nothing else, whatever it did itself before."""

from __future__ import annotations

import math
from typing import Any

from skylimb.apps.studio.gestures import marks_of
from skylimb.apps.studio.session import Session
from skylimb.apps.studio.surface_edits import surface_now


def live_state(session: Session) -> dict[str, Any]:
    """The state of the flights now, ready for JSON.

    Returns:
        `controllers`, by the names under which they are offered; `gains` of each flight that changed since
        take-off, by key; `surface` of the flight that is shown; `push` that is held, or None; `events` of
        the flights, each gesture as one (`marks_of`); `branches`, `here`, `undo` and `redo`
        (`Branches.sent`); `over` and `verdict`.
    """
    live = session.live
    shown, push = live.shown, session.pushed
    return {
        "controllers": session.flown,
        "gains": [live.gains_now(number) for number in range(len(live.flights))],
        "surface": surface_now(shown.experiment, shown.time),
        "push": push and {"link": push.link, "point": push.point, "force": push.force},
        "events": marks_of(live.flights, push),
        "over": live.over,
        "verdict": live.verdict if live.over else [],
        **session.branches.sent(),
    }


def next_event(session: Session) -> float:
    """Time at which something happens next that the experiment asks for, s: the state is another then."""
    times = [one.time for flight in session.live.flights for one in flight.experiment.events]
    return min((time for time in times if time > session.live.time), default=math.inf)
