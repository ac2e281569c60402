"""A studio's session that keeps what it says, for a test to look at."""

from __future__ import annotations

from typing import Any

from skylimb.apps.studio.session import Session as SilentSession


class Session(SilentSession):
    """Keeps what happens until it is asked for."""

    def __init__(self, *arguments: Any, **more: Any) -> None:
        super().__init__(*arguments, **more)
        self._told: list[dict[str, Any]] = []
        self.say = lambda event, content: self._told.append({"event": event, **content})

    def events(self) -> list[dict[str, Any]]:
        """What has happened since the last call."""
        told, self._told = self._told, []
        return told
