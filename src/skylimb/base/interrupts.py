"""Signals of the operating system, answered for a while."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def answering(numbers: Iterable[int], answer: Callable[[int, FrameType | None], object]) -> Iterator[None]:
    """Let a function answer these signals. Only the main thread hears them: in any other nothing changes."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.signal(number, answer) for number in numbers}
    try:
        yield
    finally:
        for number, earlier in before.items():
            signal.signal(number, earlier)
