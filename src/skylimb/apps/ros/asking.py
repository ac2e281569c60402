"""A user's calls that wait for an answer: handed to the flight, which answers at its next tick."""

from __future__ import annotations

import itertools
import threading
import time
from collections import deque
from typing import Any, NamedTuple

from skylimb.apps.ros.messages import Arrived

PATIENCE = 2.0
"""Seconds in which a flight answers; a tick is 5 ms."""


class Switch(NamedTuple):
    """A call that switches something.

    Attributes:
        token: of its answer.
        on: whether it is to be on.
    """

    token: int
    on: bool


class Calls:
    """Calls that wait, from threads of a middleware's own."""

    def __init__(self) -> None:
        self._waiting: dict[int, tuple[threading.Event, list[tuple[bool, str]]]] = {}
        self._tokens, self._came = itertools.count(1), deque[Arrived]()

    def ask(self, topic: str, on: bool | None = None) -> tuple[bool, str]:
        """Hand a call on, and wait for whether it is obeyed, with words.

        Args:
            topic: what is called.
            on: of what is switched; None of an order, whose value is its token.
        """
        token, event, found = next(self._tokens), threading.Event(), list[tuple[bool, str]]()
        self._waiting[token] = event, found
        value: Any = token if on is None else Switch(token, on)
        self._came.append(Arrived(topic, value, "service", time.monotonic()))
        event.wait(PATIENCE)
        self._waiting.pop(token, None)
        return found[0] if found else (False, f"no answer within {PATIENCE:g} s")

    def add(self, arrived: Arrived) -> None:
        """Hand on what waits for nothing."""
        self._came.append(arrived)

    def take(self) -> list[Arrived]:
        """What has come."""
        return [self._came.popleft() for _ in range(len(self._came))]

    def answer(self, token: int, obeyed: bool, words: str) -> None:
        """What came of a call."""
        if token in self._waiting:  # whoever asked has not given up
            event, found = self._waiting[token]
            found.append((obeyed, words))
            event.set()
