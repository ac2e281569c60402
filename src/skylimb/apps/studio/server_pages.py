"""The pages that are connected: who drives, who watches, and what each of them has yet to be sent."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from dataclasses import dataclass, field

import numpy as np

FRAME, HISTORY = 1, 2
"""Kinds of binary messages: the first of four uint32 in front of the numbers; number, scene, width follow."""

UNCONFIRMED = 3
"""Frames that a page may have outstanding; more would queue up somewhere on a slow line."""

FORGIVEN = 1.0
"""Seconds after which an unconfirmed frame counts as lost."""

SEAT_KEPT = 10.0
"""Seconds for which the seat of a driver that has left is kept."""


class TokenBucket:
    """Lets through `rate` messages a second, and `burst` at once, so that no page keeps the flight busy."""

    def __init__(self, rate: float, burst: float) -> None:
        self._rate, self._burst = rate, burst
        self._left, self._then = burst, time.monotonic()

    def take(self) -> bool:
        """Whether one more may pass now."""
        now = time.monotonic()
        self._left = min(self._burst, self._left + self._rate * (now - self._then))
        self._then = now
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True


@dataclass(eq=False)
class Page:
    """One connected page.

    Attributes:
        name: it keeps it over a reload, so that it comes back to its seat.
        may_drive: whether its address lets it do more than watch.
        texts: events that it has yet to be sent.
        bucket: lets its messages through.
        refusals: lets through what it is given of refused ones.
        news: set when there may be something to send.
        sent: number of the newest frame that it was sent.
        got: number of the newest frame that it has confirmed.
        history_due: whether it has yet to be sent the past.
    """

    name: str
    may_drive: bool = True
    texts: deque[str] = field(default_factory=lambda: deque(maxlen=200))
    news: asyncio.Event = field(default_factory=asyncio.Event)
    bucket: TokenBucket = field(default_factory=lambda: TokenBucket(rate=200.0, burst=400.0))
    refusals: TokenBucket = field(default_factory=lambda: TokenBucket(rate=1.0, burst=1.0))
    sent: int = 0
    got: int = 0
    sent_at: float = 0.0
    history_due: bool = False

    def may_be_sent(self, number: int) -> bool:
        """Whether a frame with this number should go out now."""
        if number <= self.sent:
            return False
        return self.sent - self.got < UNCONFIRMED or time.monotonic() - self.sent_at > FORGIVEN


class Seats:
    """Who drives: the first page, until another takes over or it has been away for `SEAT_KEPT`."""

    def __init__(self) -> None:
        self.pages: list[Page] = []
        self._driver = ""
        self._left: float | None = None

    def enter(self, page: Page) -> None:
        """A page has connected; it drives if it did before, or if nobody does."""
        self.pages.append(page)
        if page.name == self._driver:
            self._left = None
        elif page.may_drive and (not self._driver or self.seat_is_free):
            self.take(page)

    def leave(self, page: Page) -> bool:
        """A page is away; whether it drove."""
        self.pages.remove(page)
        drove = page.name == self._driver and not any(other.name == page.name for other in self.pages)
        if drove:
            self._left = time.monotonic()
        return drove

    def take(self, page: Page) -> None:
        """Let a page drive."""
        self._driver, self._left = page.name, None

    def drives(self, page: Page) -> bool:
        """Whether this page's commands are obeyed."""
        return page.name == self._driver

    @property
    def seat_is_free(self) -> bool:
        """Whether the driver has been away for too long."""
        return self._left is not None and time.monotonic() - self._left > SEAT_KEPT

    def give_free_seat(self) -> bool:
        """Let the longest connected page drive where the seat is free; whether that changed anything."""
        waiting = [page for page in self.pages if page.may_drive]
        if not self.seat_is_free or not waiting:
            return False
        self.take(waiting[0])
        return True


class History:
    """The frames of the last minutes, thinned, for pages that come back or couldn't keep up.

    Args:
        period: flight time between two that are kept, s.
        most: frames that are kept.
    """

    def __init__(self, period: float = 0.05, most: int = 3600) -> None:
        self._period = period
        self._frames: deque[tuple[int, np.ndarray]] = deque(maxlen=most)

    def clear(self) -> None:
        """Forget all, as the scene is another one."""
        self._frames.clear()

    def add(self, number: int, frame: np.ndarray) -> None:
        """Keep a frame if it is due; after a rewind, forget what comes later."""
        while self._frames and self._frames[-1][1][0] > frame[0]:
            self._frames.pop()
        if not self._frames or frame[0] - self._frames[-1][1][0] >= self._period - 1e-6:
            self._frames.append((number, frame))

    def after(self, number: int) -> bytes:
        """The frames that are newer than the one of that number, the oldest first."""
        found: list[bytes] = []
        for other, frame in reversed(self._frames):
            if other <= number:
                break
            found.append(frame.tobytes())
        return b"".join(reversed(found))
