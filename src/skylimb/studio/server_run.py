"""A studio from its beginning to Ctrl-C: session, flight thread and server put together."""

from __future__ import annotations

import sys
import threading
import webbrowser
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from skylimb.experiments.listing import list_controllers
from skylimb.studio.server import StudioServer
from skylimb.studio.server_flight import FlightThread
from skylimb.studio.session import Session

_SWITCH_INTERVAL = 0.0005
"""Longest time for which one thread keeps the interpreter, s: a tick mustn't wait for a page's message."""


class Studio:
    """A session that pages can watch and drive.

    Args:
        session: what is flown.
        controllers: names that a page may choose besides those that ship.
        host: an address or name of this machine.
        port: 0 for a free one.
        token: empty where none is needed.
    """

    def __init__(
        self, session: Session, controllers: Sequence[str], host: str, port: int, token: str
    ) -> None:
        self.server = StudioServer(host, port, token, self._obey)
        names = dict.fromkeys([*controllers, *list_controllers()])
        self.flight = FlightThread(session, self.server.say, list(names))

    def _obey(self, command: Any) -> bool:
        return self.flight.command(command)

    def run(self, ready: Callable[[str], None]) -> None:
        """Serve and fly in this thread until `flight.stop()`, or Ctrl-C.

        Args:
            ready: is handed the page's address once it can be opened.

        Raises:
            OutputError: when the port cannot be had.
        """
        before = sys.getswitchinterval()
        url = self.server.start()
        sys.setswitchinterval(_SWITCH_INTERVAL)
        try:
            ready(url)
            self.flight.run()
        finally:
            sys.setswitchinterval(before)
            self.server.stop()


def serve(
    experiment: str,
    controllers: Sequence[str],
    settings: Mapping[str, Any],
    seed: int | None,
    out: Path,
    *,
    host: str,
    port: int,
    token: str,
    browser: bool,
) -> None:
    """Fly an experiment live until Ctrl-C; prints the page's address in one line.

    Raises:
        SkylimbError: when it cannot be flown, or the port cannot be had.
    """
    session = Session(experiment, controllers, settings, seed, out)

    def ready(url: str) -> None:
        print(f"skylimb studio: {url}  (Ctrl-C ends it)", flush=True)
        if browser:
            threading.Thread(target=webbrowser.open, args=(url,), daemon=True).start()

    try:
        Studio(session, controllers, host, port, token).run(ready)
    except KeyboardInterrupt:
        print()
