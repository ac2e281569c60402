"""The studio's server: pages on one side, the flight's thread on the other.

The flight's thread puts events into the server's loop, the server puts commands into the flight's queue.
Nothing else is shared.
"""

from __future__ import annotations

import asyncio
import http
import logging
import threading
import time
import traceback
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Self
from urllib.parse import parse_qs, urlsplit

import msgspec
import numpy as np
from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from skylimb.apps.studio import messages
from skylimb.apps.studio.server_access import HEADERS, PUBLIC, Access, file_of
from skylimb.apps.studio.server_pages import FRAME, HISTORY, SEAT_KEPT, History, Page, Seats
from skylimb.base.errors import ConfigError, OutputError

SOCKET = "/socket"
"""Path of the WebSocket."""

MOST_PAGES = 16
"""Pages that may be connected at once."""

FAREWELL = 1.0
"""Seconds that pages are given to hear the last words."""

HEARTBEAT = 1.0
"""Seconds between two words that a page is sent also while the flight's thread is busy with a command."""

Obey = Callable[[Any], bool]
"""Takes a checked command; false where too many wait."""


class StudioServer:
    """Serves pages in a thread of its own, inside of `with`.

    Args:
        host: an address or name of this machine.
        port: 0 for a free one.
        token: empty where none is needed.

    Attributes:
        access: where it listens.
        obey: hands commands to the flight; none is taken before there is one.

    Raises:
        OutputError: on entering, when the port cannot be had.
    """

    def __init__(self, host: str, port: int, token: str) -> None:
        self.access = Access(host, port, token)
        self.obey: Obey = lambda command: False
        self._seats, self._history = Seats(), History()
        self._known: dict[str, dict[str, Any]] = {}
        self._scene = self._number = 0
        self._frame = b""
        self._flight_heard = time.monotonic()
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name="studio server", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        try:
            self._server = asyncio.run_coroutine_threadsafe(self._listen(), self._loop).result()
        except OSError as error:
            self._loop.call_soon_threadsafe(self._loop.stop)
            wanted = f"--port = {self.access.port} on {self.access.host}"
            raise OutputError(f"{wanted} cannot be listened on: {error.strerror}") from None
        self.access = replace(self.access, port=int(next(iter(self._server.sockets)).getsockname()[1]))
        return self

    def __exit__(self, *exception: object) -> None:
        asyncio.run_coroutine_threadsafe(self._close(), self._loop)
        self._thread.join(timeout=5.0)
        self._loop.close()

    def say(self, event: str, content: Any) -> None:
        """Tell the pages of an event; from any thread."""
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._take, event, content)

    # What follows runs in the server's own thread.

    async def _listen(self) -> Server:
        logger = logging.getLogger("skylimb.apps.studio")
        logger.addHandler(logging.NullHandler())
        logger.propagate = False  # a scanner's broken handshake is no news for the terminal
        self._heartbeat = asyncio.create_task(self._beat())
        return await serve(
            self._talk,
            self.access.host,
            self.access.port,
            process_request=self._answer,
            max_size=2 * messages.LONGEST,  # a quote or the end of a line takes two bytes in a message
            max_queue=64,
            compression=None,
            ping_interval=5.0,
            ping_timeout=10.0,
            close_timeout=1.0,
            server_header=None,
            logger=logger,
        )

    async def _close(self) -> None:
        self._heartbeat.cancel()
        until = time.monotonic() + FAREWELL
        while any(page.texts for page in self._seats.pages) and time.monotonic() < until:
            await asyncio.sleep(0.01)
        self._server.close()
        await self._server.wait_closed()
        self._loop.stop()

    async def _beat(self) -> None:
        """Tell pages that the line holds, and whether the flight's thread is busy: it is silent then."""
        while True:
            await asyncio.sleep(HEARTBEAT)
            busy = time.monotonic() - self._flight_heard > HEARTBEAT
            for page in self._seats.pages:
                if not page.texts:  # a page that does not read gets no more of them
                    self._tell(page, "alive", {"busy": busy})

    def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        """The page's files, and who is let in; None lets the WebSocket begin."""
        refused = self._refusal(request)
        if refused is not None:
            return _response(*refused)
        if urlsplit(request.path).path == SOCKET:
            return None
        found = file_of(request.path)
        if found is None:
            return _response(http.HTTPStatus.NOT_FOUND, b"There is no such page.\n")
        return _response(http.HTTPStatus.OK, *found)

    def _refusal(self, request: Request) -> tuple[http.HTTPStatus, bytes] | None:
        """Why a request isn't answered; None where it is."""
        host, path = request.headers.get("Host"), urlsplit(request.path).path
        if not self.access.knows_host(host):
            return http.HTTPStatus.FORBIDDEN, b"This is not the studio's address.\n"
        if path not in PUBLIC and not self.access.may_watch(request.path):
            return http.HTTPStatus.FORBIDDEN, b"The address needs the studio's token.\n"
        if path != SOCKET:
            return None
        if not self.access.knows_origin(request.headers.get("Origin"), host):
            return http.HTTPStatus.FORBIDDEN, b"Another site may not talk to the studio.\n"
        if len(self._seats.pages) >= MOST_PAGES:
            return http.HTTPStatus.SERVICE_UNAVAILABLE, b"Too many pages are open.\n"
        return None

    async def _talk(self, connection: ServerConnection) -> None:
        """One page, from its connection to its end."""
        path = connection.request.path if connection.request else ""
        name = parse_qs(urlsplit(path).query).get("page", [""])[0]
        page = Page(name[:64] or f"page {id(connection)}", self.access.may_drive(path))
        self._seats.enter(page)
        self._greet(page)
        self._tell_who_drives()
        writer = asyncio.create_task(self._write(connection, page))
        writer.add_done_callback(_complain)
        try:
            async for message in connection:
                self._read(page, message)
        except ConnectionClosed:
            pass
        finally:
            writer.cancel()
            if self._seats.leave(page):
                self.obey(messages.Release())  # nobody holds the poke any more
                self._loop.call_later(SEAT_KEPT + 0.1, self._give_free_seat)
            self._tell_who_drives()

    def _give_free_seat(self) -> None:
        if self._seats.give_free_seat():
            self._tell_who_drives()

    def _read(self, page: Page, message: str | bytes) -> None:
        """Obey one message, or say why not."""
        try:
            command = messages.read_command(message)
        except ConfigError as error:
            page.bucket.take()
            self._refuse(page, str(error))
            return
        if isinstance(command, messages.Got):
            page.got = max(page.got, min(command.frame, page.sent))
            page.news.set()
        elif not page.bucket.take():
            self._refuse(page, "too many messages; some are not obeyed")
        elif not page.may_drive:
            self._refuse(page, "this page has the address for watching only")
        elif isinstance(command, messages.TakeOver):
            self._seats.take(page)
            self.obey(messages.Release())
            self._tell_who_drives()
        elif not self._known:
            self._tell(page, "refused", {"text": "the flight is still being put together"})
        elif not self._seats.drives(page):
            self._tell(page, "refused", {"text": "this page watches; take over to drive"})
        elif not self.obey(command):
            self._tell(page, "refused", {"text": "too much waits to be done; this is not"})

    def _refuse(self, page: Page, why: str) -> None:
        """Say why a message is not obeyed; of many refusals only some are said."""
        if page.refusals.take():
            self._tell(page, "refused", {"text": why})

    def _take(self, event: str, content: Any) -> None:
        """One event from the flight."""
        self._flight_heard = time.monotonic()
        if event == "frame":
            self._number += 1
            frame = np.ascontiguousarray(content, dtype="<f4")
            self._history.add(self._number, frame)
            self._frame = frame.tobytes()
            for page in self._seats.pages:
                page.news.set()
        elif event == "past":
            for frame in content:
                self._history.add(self._number, np.ascontiguousarray(frame, dtype="<f4"))
            for page in self._seats.pages:
                page.history_due = True
        elif event == "scene":
            self._scene = content["hello"]["number"]
            self._history.clear()
            self._frame = b""
            self._known = content
            for page in self._seats.pages:
                self._greet(page)
        else:
            if event in ("state", "error"):
                self._known[event] = content
            for page in self._seats.pages:
                self._tell(page, event, content)

    def _greet(self, page: Page) -> None:
        """All that a page needs to begin, the scene first; nothing before the flight is put together."""
        for event, content in self._known.items():
            self._tell(page, event, content)
        page.history_due = bool(self._known)

    def _tell_who_drives(self) -> None:
        watchers = len(self._seats.pages) - 1
        for page in self._seats.pages:
            seat = {"drives": self._seats.drives(page), "others": watchers, "may_drive": page.may_drive}
            self._tell(page, "seats", seat | ({"watch": self.access.watching_url} if page.may_drive else {}))

    def _tell(self, page: Page, event: str, content: dict[str, Any]) -> None:
        # NumPy's numbers become Python's; a number that is none becomes null.
        said = msgspec.json.encode({"event": event, **content}, enc_hook=lambda value: value.item())
        page.texts.append(said.decode())
        page.news.set()

    async def _write(self, connection: ServerConnection, page: Page) -> None:
        """Send what a page has yet to get: all events, the newest frame, and missed ones thinned."""
        while True:
            await page.news.wait()
            page.news.clear()
            while page.texts:
                await connection.send(page.texts.popleft())
            if page.history_due and self._frame:
                page.history_due = False
                await connection.send(self._numbers(HISTORY, self._history.after(0)))
            number = self._number
            if self._frame and page.may_be_sent(number):
                missed = self._history.after(page.sent) if page.sent else b""
                page.sent, page.sent_at = number, time.monotonic()
                await connection.send(self._numbers(FRAME, missed + self._frame))

    def _numbers(self, kind: int, frames: bytes) -> bytes:
        """One message with some frames, the newest last, behind a header of 16 bytes."""
        header = np.array([kind, self._number, self._scene, len(self._frame) // 4], dtype="<u4")
        return header.tobytes() + frames


def _complain(task: asyncio.Task[None]) -> None:
    """Show a mistake of this program; that a page has gone is none."""
    error = None if task.cancelled() else task.exception()
    if error is not None and not isinstance(error, ConnectionClosed):
        traceback.print_exception(error)


def _response(status: http.HTTPStatus, body: bytes, kind: str = "text/plain; charset=utf-8") -> Response:
    headers = Headers(**HEADERS)
    headers["Content-Type"] = kind
    headers["Content-Length"] = str(len(body))
    headers["Connection"] = "close"
    return Response(status.value, status.phrase, headers, body)
