"""Signals of the operating system, answered for a while."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any


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


@contextmanager
def answering_first(
    numbers: Iterable[int], answer: Callable[[int, FrameType | None], object]
) -> Iterator[None]:
    """Let a function answer the first of these signals; those after it are answered as they were before."""
    before = {number: signal.getsignal(number) for number in numbers}

    def first(number: int, frame: FrameType | None) -> None:
        for one, earlier in before.items():
            signal.signal(one, earlier)
        answer(number, frame)

    with answering(before, first):
        yield


def solved(solver: Any) -> bool:
    """Whether the last call of a nonlinear solver (a `casadi.Function` by IPOPT) found something.

    IPOPT swallows the Ctrl-C that ends a search and calls it a failed one; a plan would go on with the next.

    Raises:
        KeyboardInterrupt: the search was interrupted.
    """
    stats = solver.stats()
    if stats["return_status"] == "NonIpopt_Exception_Thrown":
        raise KeyboardInterrupt
    return bool(stats["success"])
