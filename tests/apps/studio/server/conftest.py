"""A studio that runs in a thread of the test, and a client that talks to it as a page does."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from websockets.sync.client import ClientConnection, connect

from skylimb.apps.studio.messages import Speed
from skylimb.apps.studio.server import StudioServer
from skylimb.apps.studio.server_run import flight_of
from skylimb.apps.studio.session import Session

PATIENCE = 60.0
"""Seconds for which a test waits for anything, on a machine that has much else to do."""


class Client:
    """A page without a browser: it shows the last state that it was told."""

    def __init__(self, connection: ClientConnection) -> None:
        self.connection = connection
        self.hello: dict[str, Any] = {}
        self.state: dict[str, Any] = {}
        self.frames: list[np.ndarray] = []
        self.history = b""

    def say(self, what: str, **content: Any) -> None:
        self.connection.send(json.dumps({"do": what, **content}))

    def event(self, name: str) -> dict[str, Any]:
        """The next event of a name; frames that come before it are confirmed and kept."""
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until:
            content = self.hear()
            if content["event"] == name:
                return content
        raise TimeoutError(name)

    def hear(self, timeout: float = PATIENCE) -> dict[str, Any]:
        """The next message."""
        message = self.connection.recv(timeout=timeout)
        if not isinstance(message, str):
            return {"event": "frame" if self._take(message) else "history"}
        content = json.loads(message)
        if content["event"] == "hello":
            self.hello = content
        elif content["event"] == "state":
            self.state = content
        return content

    def state_where(self, true: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        """The state, once it is so."""
        until = time.monotonic() + PATIENCE
        while not (self.state and true(self.state)):
            assert time.monotonic() < until, self.state
            self.hear()
        return self.state

    def value(self, key: str, flight: int = 0) -> Any:
        """What this page shows of a key: what has become of it, else what it was at take-off."""
        (control,) = (one for one in self.hello["controls"] if one["key"] == key)
        if "flights" in control:
            own = control["values"][control["flights"].index(flight)]
            return self.state["gains"][flight].get(key.removeprefix("controller."), own)
        return self.state["surface"].get(key.removeprefix("surface."), control["value"])

    def frame(self) -> np.ndarray:
        """The next frame."""
        self.event("frame")
        return self.frames[-1]

    def frame_where(self, true: Callable[[np.ndarray], bool]) -> np.ndarray:
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until:
            frame = self.frame()
            if true(frame):
                return frame
        raise TimeoutError("no such frame")

    def _take(self, message: bytes) -> bool:
        """Keep frames; whether they are new ones."""
        kind, number, _, width = np.frombuffer(message[:16], dtype="<u4")
        if kind == 1:
            self.say("got", frame=int(number))
            self.frames.extend(np.frombuffer(message[16:], dtype="<f4").reshape(-1, int(width)))
        else:
            self.history = message
        return kind == 1


class Running:
    """A studio in a thread of its own."""

    def __init__(self, server: StudioServer, session: Session) -> None:
        self.server, self.session, self.url = server, session, server.access.url
        self.flight = flight_of(server, session)
        self._thread = threading.Thread(target=self.flight.run, daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self.flight.stop()
        self._thread.join(PATIENCE)
        assert not self._thread.is_alive()

    def speed(self, times: float) -> None:
        self.flight.command(Speed(times=times))

    @property
    def port(self) -> int:
        return self.server.access.port

    @contextmanager
    def page(self, name: str = "first", token: str = "", **headers: Any) -> Iterator[Client]:
        origin = headers.pop("origin", f"http://127.0.0.1:{self.port}")
        address = f"ws://127.0.0.1:{self.port}/socket?page={name}&token={token}"
        with connect(address, origin=origin, max_size=2**24, max_queue=None, **headers) as connection:
            page = Client(connection)
            if name == "first":  # a driver whose page is closed keeps the seat for a while
                page.say("take over")
            yield page


@contextmanager
def running(
    out: Path,
    *controllers: str,
    token: str = "",
    experiment: str = "free_flight",
    keys: Mapping[str, Any] | None = None,
) -> Iterator[Running]:
    """A studio, until the end of the block."""
    session = Session(experiment, controllers, keys, out=out)
    with StudioServer("127.0.0.1", 0, token) as server:
        found = Running(server, session)
        found.start()
        yield found
        found.stop()


@pytest.fixture(scope="session")
def run_studio() -> Callable[..., Any]:
    """`running`, for tests that want a studio of their own."""
    return running


@pytest.fixture(scope="module")
def studio(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    """One for each file of tests: what one file changes stays changed."""
    with running(tmp_path_factory.mktemp("studio")) as found:
        yield found
