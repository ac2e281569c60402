"""A studio from its beginning to Ctrl-C: server, session and flight thread put together."""

from __future__ import annotations

import ctypes
import sys
import threading
import webbrowser
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from skylimb.apps.studio.server import StudioServer
from skylimb.base.sources import read_source
from skylimb.control.preset import preset_mapping
from skylimb.flight.experiments.experiment import load_experiment
from skylimb.flight.experiments.listing import list_controllers

if TYPE_CHECKING:
    from skylimb.apps.studio.server_flight import FlightThread
    from skylimb.apps.studio.session import Session

_SWITCH_INTERVAL = 0.0005
"""Longest time for which one thread keeps the interpreter, s: a tick mustn't wait for a page's message."""

_MMAP_THRESHOLD, _LARGE = -3, 1 << 20
"""Option of mallopt (malloc.h), and the size from which on an array gets memory of its own, bytes."""


class Studio:
    """Pages on one side, a session that they watch and drive on the other. It listens inside of `with`.

    Args:
        host: an address or name of this machine.
        port: 0 for a free one.
        token: empty where none is needed.

    Attributes:
        url: the page's address.

    Raises:
        OutputError: on entering, when the port cannot be had.
    """

    def __init__(self, host: str, port: int, token: str) -> None:
        self.server = StudioServer(host, port, token, self._obey)
        self._flight: FlightThread | None = None
        self.url = ""

    def __enter__(self) -> Self:
        self.url = self.server.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.server.stop()

    def _obey(self, command: Any) -> bool:
        return self._flight is not None and self._flight.command(command)

    def take(self, session: Session, controllers: Sequence[str] = ()) -> FlightThread:
        """Let pages watch and drive a session; its `run` flies it.

        Args:
            session: what is flown.
            controllers: names that a page may choose besides those that ship.
        """
        from skylimb.apps.studio.server_flight import FlightThread

        names = dict.fromkeys([*controllers, *list_controllers()])
        self._flight = FlightThread(session, self.server.say, list(names))
        return self._flight

    def fly(self, session: Session, controllers: Sequence[str] = ()) -> None:
        """Fly a session in this thread until Ctrl-C."""
        flight = self.take(session, controllers)
        before = sys.getswitchinterval()
        sys.setswitchinterval(_SWITCH_INTERVAL)
        try:
            flight.run()
        finally:
            sys.setswitchinterval(before)


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

    The page is served before the flight is put together, so that the browser loads it in the meantime.

    Raises:
        SkylimbError: when it cannot be flown, or the port cannot be had.
    """
    _check_names(experiment, controllers, settings)
    with Studio(host, port, token) as studio:
        print(f"skylimb studio: {studio.url}  (Ctrl-C ends it)", flush=True)
        if browser:
            threading.Thread(target=webbrowser.open, args=(studio.url,), daemon=True).start()
        try:
            from skylimb.apps.studio.session import Session

            _give_large_arrays_back()
            studio.fly(Session(experiment, controllers, settings, seed, out), controllers)
        except KeyboardInterrupt:
            print()


def _check_names(experiment: str, controllers: Sequence[str], settings: Mapping[str, Any]) -> None:
    """Refuse a name that cannot be before a page opens; what it stands for is checked at take-off.

    Raises:
        SkylimbError: when there is no such experiment, key or controller.
    """
    load_experiment(experiment, {key: settings[key] for key in settings if not key.startswith("controller.")})
    for name in controllers:
        if name.endswith(".py"):
            read_source(Path(name))
        else:
            preset_mapping(name)


def _give_large_arrays_back() -> None:
    """Let the memory of a flight's log go back to the system when the flight goes.

    glibc raises the size from which on it does so each time that a larger array is freed; flights after each
    other then leave holes in the heap, and a studio that is left open for an hour grows without end. Other C
    libraries have no such option, nor the trouble.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None) if sys.platform == "linux" else None
    if mallopt is not None:
        mallopt(_MMAP_THRESHOLD, _LARGE)
