"""What is said goes to a thread: readers that are gone, or do not read, hold nobody up."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from typing import TextIO

import pytest

from skylimb.base import aside
from skylimb.base.aside import said_aside

Ends = tuple[TextIO, int]


@contextmanager
def piped() -> Iterator[Ends]:
    """Standard output into a pipe, and the end where its reader is."""
    reader, writer = os.pipe()
    with os.fdopen(writer, "w", buffering=1) as stream, redirect_stdout(stream):
        yield stream, reader


def test_what_is_said_is_read_in_its_order() -> None:
    with piped() as (stream, reader):
        with said_aside() as words:
            for k in range(3):
                print(k, flush=True)
            assert not sys.stdout.isatty()
        assert words.lost == 0
        assert sys.stdout is stream
        os.set_blocking(reader, False)
        assert os.read(reader, 100) == b"0\n1\n2\n"
    os.close(reader)


def test_a_reader_who_is_gone_ends_nobody() -> None:
    with piped() as (_, reader):
        os.close(reader)
        with said_aside() as words:
            print("a word")
            print("another one")
        assert words.lost >= 1
        print("nor afterwards", flush=True)


def test_a_reader_who_does_not_read_holds_nobody_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(aside, "MOST", 10)
    begun = time.monotonic()
    with piped() as (_, reader):
        with said_aside(patience=0.05) as words:
            for _ in range(100):
                print("x" * 8192)
        assert time.monotonic() - begun < 2.0
        assert words.lost > 50
        os.set_blocking(reader, False)
        while words._writer.is_alive():  # it reads at last: the writer's thread ends
            try:
                os.read(reader, 1 << 20)
            except BlockingIOError:
                time.sleep(0.001)
    os.close(reader)
