"""Signals are answered for a while, and by who answered before after it."""

from __future__ import annotations

import signal
import threading

from skylimb.base.interrupts import answering


def test_an_answer_holds_within_and_ends_with_it() -> None:
    heard: list[int] = []
    before = signal.getsignal(signal.SIGUSR1)
    with answering([signal.SIGUSR1], lambda number, _: heard.append(number)):
        signal.raise_signal(signal.SIGUSR1)
    assert heard == [signal.SIGUSR1]
    assert signal.getsignal(signal.SIGUSR1) is before


def test_another_thread_answers_nothing() -> None:
    before, seen = signal.getsignal(signal.SIGUSR1), []

    def within() -> None:
        with answering([signal.SIGUSR1], lambda number, frame: None):
            seen.append(signal.getsignal(signal.SIGUSR1))

    thread = threading.Thread(target=within)
    thread.start()
    thread.join()
    assert seen == [before]
