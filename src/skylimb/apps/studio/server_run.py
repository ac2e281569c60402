"""A studio from its beginning to Ctrl-C: server, session and flight thread put together."""

from __future__ import annotations

import ctypes
import signal
import sys
import threading
import webbrowser
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any

from skylimb.apps.studio.beside import require_beside
from skylimb.apps.studio.server import StudioServer
from skylimb.base.files import require_room
from skylimb.base.interrupts import ENDS, answering_first, raising_again
from skylimb.base.sources import read_source
from skylimb.control.laws.preset import preset_mapping
from skylimb.flight.experiments.experiment import load_experiment

if TYPE_CHECKING:
    from skylimb.apps.studio.server_flight import FlightThread
    from skylimb.apps.studio.session import Session

_SWITCH_INTERVAL = 0.0005
"""Longest time for which one thread keeps the interpreter, s: a tick mustn't wait for a page's message."""

_MMAP_THRESHOLD, _LARGE = -3, 1 << 20
"""Option of mallopt (malloc.h), and the size from which on an array gets memory of its own, bytes."""


def flight_of(server: StudioServer, session: Session) -> FlightThread:
    """The thread in which a session flies that the server's pages watch and drive; its `run` flies it."""
    from skylimb.apps.studio.server_flight import FlightThread

    flight = FlightThread(session, server.say)
    server.obey = flight.command
    return flight


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

    The first signal that asks for the end lets the tick, or the command, under way come to its end; the
    second breaks it off.

    The page is served before the flight is put together, so that the browser loads it in the meantime.

    Raises:
        SkylimbError: when it cannot be flown, or the port cannot be had.
    """
    _check_names(experiment, controllers, settings)
    require_room(out / "live")
    with StudioServer(host, port, token) as server:
        url = server.access.url
        print(f"skylimb studio: {url}  (Ctrl-C ends it)", flush=True)
        if server.access.watching_url:
            print(f"to watch only:  {server.access.watching_url}", flush=True)
        if browser:
            threading.Thread(target=webbrowser.open, args=(url,), daemon=True).start()
        try:
            from skylimb.analysis.exchange.recorder import recording
            from skylimb.apps.studio.session import Session

            _give_large_arrays_back()
            with recording(out / "live") as recorder:
                with raising_again():
                    session = Session(experiment, controllers, settings, seed, out)
                sys.setswitchinterval(_SWITCH_INTERVAL)
                flight, ended = flight_of(server, session), list[int]()

                def end(number: int, _: FrameType | None) -> None:
                    ended.append(number)
                    flight.stop()

                # Nothing is raised in flight: what a command has begun comes to its end, and so does a tick.
                with answering_first(ENDS, end):
                    # The record takes most of a second to load; pages draw their first picture meanwhile.
                    flight.run(lambda: recorder and session.record(recorder))
                # Where the system asks for the end, or the terminal is gone, nobody could keep the flight.
                alone = set(ended) - {signal.SIGINT}
                folder = str(session.keep().folder) if alone else ""
                server.say("farewell", {"folder": folder})
                print(f"\nThe studio has ended{folder and f'; the flight is kept in {folder}'}.")
        except KeyboardInterrupt as stop:
            print("\nThe studio has ended.", *getattr(stop, "__notes__", ()), sep="\n")


def _check_names(experiment: str, controllers: Sequence[str], settings: Mapping[str, Any]) -> None:
    """Refuse a name that cannot be before a page opens; what it stands for is checked at take-off.

    Raises:
        SkylimbError: when there is no such experiment, key or controller, or two cannot fly side by side.
    """
    load_experiment(experiment, {key: settings[key] for key in settings if not key.startswith("controller.")})
    require_beside(controllers)
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
