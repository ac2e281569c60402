"""Signals are answered for a while, and by who answered before after it."""

from __future__ import annotations

import signal
import threading

import casadi as ca
import numpy as np
import pytest

from skylimb.base.interrupts import answering
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


def test_ctrl_c_ends_a_search_and_not_just_this_start_of_it() -> None:
    x = ca.SX.sym("x", 3000)
    valley = 100.0 * ca.sumsqr(x[1:] - x[:-1] ** 2) + ca.sumsqr(1.0 - x)  # Rosenbrock's, for seconds
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, 0.2)
    try:
        with pytest.raises(KeyboardInterrupt):
            search(ipopt({"x": x, "f": valley}, 5000), np.full(3000, -1.2))
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
