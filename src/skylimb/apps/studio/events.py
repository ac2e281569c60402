"""What has happened in a session, kept until somebody takes it."""

from __future__ import annotations

from collections import deque
from typing import Any

from skylimb.base.errors import SkylimbError
from skylimb.base.user_code import place_of

_MOST = 1000
"""Events that are kept when nobody takes any; older ones are dropped."""


class Events:
    """Events in their order: `event`, `time` and what belongs to it."""

    def __init__(self) -> None:
        self._waiting: deque[dict[str, Any]] = deque(maxlen=_MOST)

    def add(self, event: str, time: float, **what: Any) -> None:
        """Something happened at a time of the flight, s."""
        self._waiting.append({"event": event, "time": time, **what})

    def fail(self, error: SkylimbError, time: float, **what: Any) -> None:
        """Something went wrong; where that was in a file of the user's is said as well."""
        place = place_of(error)
        at = {"file": place.file, "line": place.line} if place else {}
        self.add("error", time, text=str(error), **at, **what)

    def take(self) -> list[dict[str, Any]]:
        """What has happened since the last call."""
        found = list(self._waiting)
        self._waiting.clear()
        return found
