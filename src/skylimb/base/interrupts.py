"""Signals of the operating system, answered for a while."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any


def _known(*names: str) -> tuple[signal.Signals, ...]:
    """Those of some signals that this system has."""
    return tuple(getattr(signal, name) for name in names if hasattr(signal, name))


HANG_UP = _known("SIGHUP")
"""That of a terminal that goes away: its window is closed, or its connection has dropped."""

ENDS = (signal.SIGINT, signal.SIGTERM, *HANG_UP)
"""Signals that ask for the end: Ctrl-C, that of the system, and that of a terminal that goes away."""

FREEZES = _known("SIGTSTP", "SIGTTIN", "SIGTTOU")
"""Signals that would stop a process where it stands: Ctrl-Z, and what a terminal sends to the background."""


Answer = Callable[[int, FrameType | None], object] | signal.Handlers
"""Who answers a signal."""


def insists(number: int) -> bool:
    """Whether its sender asks for more with a second signal; of a closed window several come."""
    return number not in HANG_UP


def ignore(numbers: Iterable[int]) -> None:
    """Ignore these signals from now on, as whoever started this process answers them."""
    for number in numbers:
        signal.signal(number, signal.SIG_IGN)


@contextmanager
def answering(numbers: Iterable[int], answer: Answer) -> Iterator[None]:
    """Let a function answer these signals, or nobody (`signal.SIG_IGN`).

    Only the main thread hears them: in any other nothing changes. Who was started to outlive its terminal
    (`nohup`) goes on doing so.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    outlives = [number for number in HANG_UP if signal.getsignal(number) == signal.SIG_IGN]
    before = {number: signal.signal(number, answer) for number in numbers if number not in outlives}
    try:
        yield
    finally:
        for number, earlier in before.items():
            signal.signal(number, earlier)


@contextmanager
def answering_first(
    numbers: Iterable[int], answer: Callable[[int, FrameType | None], object]
) -> Iterator[None]:
    """Let a function answer the first of these signals; those after it are answered as they were before.

    But for a terminal that goes away: that asks for no more than the first one did.
    """
    before = {number: signal.getsignal(number) for number in numbers}

    def first(number: int, frame: FrameType | None) -> None:
        for one, earlier in before.items():
            signal.signal(one, earlier if insists(one) else signal.SIG_IGN)
        answer(number, frame)

    with answering(before, first):
        yield


@contextmanager
def unfrozen() -> Iterator[None]:
    """Nothing stops this process where it stands, as Ctrl-Z would."""
    with answering(FREEZES, signal.SIG_IGN):
        yield


@contextmanager
def raising_again(numbers: Iterable[int] = ENDS) -> Iterator[None]:
    """Let what a signal's answer raises within come out of the block, also where it was swallowed there.

    An answer runs wherever the main thread happens to be. What it raises inside of C code that calls Python
    or looks for signals itself, or in a destructor, may get lost there: IPOPT takes it for a point at which
    the problem has no value, and goes on to the next.

    Raises:
        KeyboardInterrupt: or whatever the answer has raised.
    """
    before = {number: signal.getsignal(number) for number in numbers}
    raised = list[BaseException]()

    def answer(number: int, frame: FrameType | None) -> None:
        earlier = before[number]
        assert callable(earlier)
        try:
            earlier(number, frame)
        except BaseException as error:
            raised.append(error)
            raise

    try:
        with answering([number for number, earlier in before.items() if callable(earlier)], answer):
            yield
    except Exception as error:
        if raised:  # it has become another error on its way
            raise raised[0] from error
        raise
    if raised:
        raise raised[0]


def search(solver: Any, **given: Any) -> tuple[dict[str, Any], bool]:
    """What a nonlinear solver (a `casadi.Function` by IPOPT) finds, and whether it is a solution.

    Raises:
        KeyboardInterrupt: the search was interrupted.
    """
    with raising_again():
        found = solver(**given)
    return found, bool(solver.stats()["success"])
