"""What is said goes to a thread: readers that are gone, or do not read, hold nobody up."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from typing import TextIO

import pytest

from skylimb.base import aside
from skylimb.base.aside import said_aside

Ends = tuple[TextIO, int]


@pytest.fixture
def ends(monkeypatch: pytest.MonkeyPatch) -> Iterator[Ends]:
    """Standard output into a pipe, and the end where its reader is."""
    reader, writer = os.pipe()
    with os.fdopen(writer, "w", buffering=1) as stream:
        monkeypatch.setattr(sys, "stdout", stream)
        yield stream, reader
    monkeypatch.undo()


def test_what_is_said_is_read_in_its_order(ends: Ends) -> None:
    with said_aside() as words:
        for k in range(3):
            print(k, flush=True)
        assert not sys.stdout.isatty()
    assert os.read(ends[1], 100) == b"0\n1\n2\n"
    assert words.lost == 0
    assert sys.stdout is ends[0]


def test_a_reader_who_is_gone_ends_nobody(ends: Ends) -> None:
    os.close(ends[1])
    with said_aside() as words:
        print("a word")
        print("another one")
    assert words.lost >= 1
    print("nor afterwards", flush=True)


def test_a_reader_who_does_not_read_holds_nobody_up(ends: Ends, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(aside, "MOST", 10)
    begun = time.monotonic()
    with said_aside(patience=0.05) as words:
        for _ in range(100):
            print("x" * 8192)
    assert time.monotonic() - begun < 2.0
    assert words.lost > 50
    os.set_blocking(ends[1], False)
    while words._writer.is_alive():  # it reads at last: the writer's thread ends
        try:
            os.read(ends[1], 1 << 20)
        except BlockingIOError:
            time.sleep(0.001)
    os.close(ends[1])
