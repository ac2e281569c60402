"""Signals are answered for a while, and by who answered before after it."""

from __future__ import annotations

import os
import signal
import threading
import time
from types import FrameType

import casadi as ca
import numpy as np
import pytest

from skylimb.base.interrupts import ENDS, FREEZES, answering, answering_first, raising_again, unfrozen
from skylimb.control.planning.nlp import ipopt, search


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


def test_of_a_terminal_that_goes_away_one_signal_counts_however_many_come() -> None:
    heard, later = [], []
    with (
        answering(ENDS, lambda number, _: later.append(number)),
        answering_first(ENDS, lambda number, _: heard.append(number)),
    ):
        for _ in range(3):
            signal.raise_signal(signal.SIGHUP)
        assert (heard, later) == ([signal.SIGHUP], [])
        signal.raise_signal(signal.SIGINT)
    assert (heard, later) == ([signal.SIGHUP], [signal.SIGINT])


def test_who_is_to_outlive_its_terminal_does() -> None:
    heard: list[int] = []
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with answering_first(ENDS, lambda number, _: heard.append(number)):
            signal.raise_signal(signal.SIGHUP)
        assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)
    assert heard == []


def test_ctrl_z_stops_nobody_who_must_not_stand_still() -> None:
    before = signal.getsignal(signal.SIGTSTP)
    with unfrozen():
        assert {signal.getsignal(number) for number in FREEZES} == {signal.SIG_IGN}
    assert signal.getsignal(signal.SIGTSTP) == before


def test_ctrl_c_ends_a_search_and_not_just_this_start_of_it() -> None:
    x = ca.SX.sym("x", 3000)
    valley = 100.0 * ca.sumsqr(x[1:] - x[:-1] ** 2) + ca.sumsqr(1.0 - x)  # Rosenbrock's, for seconds
    solver = ipopt({"x": x, "f": valley}, 5000)

    def searched_for_seconds() -> None:
        search(solver, np.full(3000, -1.2))
        time.sleep(5.0)  # where the search was shorter than the timer

    timer = threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGINT))
    with answering([signal.SIGINT], signal.default_int_handler):
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            searched_for_seconds()
    timer.join()


class _Swallows:
    """Its destructor hears a signal: what the answer raises there goes no farther."""

    def __del__(self) -> None:
        signal.raise_signal(signal.SIGTERM)


def _asked(number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt(signal.Signals(number).name)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_an_interrupt_that_was_swallowed_comes_out_of_the_block() -> None:
    after: list[str] = []

    @raising_again()
    def swallowed() -> None:
        _Swallows()
        after.append("it went on")

    with answering([signal.SIGTERM], _asked), pytest.raises(KeyboardInterrupt, match="SIGTERM"):
        swallowed()
    assert after


def test_an_interrupt_that_became_another_error_is_one_again() -> None:
    @raising_again()
    def renamed() -> None:
        try:
            signal.raise_signal(signal.SIGTERM)
        except KeyboardInterrupt:
            raise RuntimeError("a library's own") from None

    with answering([signal.SIGTERM], _asked), pytest.raises(KeyboardInterrupt, match="SIGTERM"):
        renamed()


def test_a_signal_that_nobody_answers_in_python_is_left_alone() -> None:
    with answering([signal.SIGUSR1], signal.default_int_handler):
        signal.signal(signal.SIGUSR1, signal.SIG_IGN)
        with raising_again([signal.SIGUSR1]):
            assert signal.getsignal(signal.SIGUSR1) is signal.SIG_IGN
