"""What is said in a flight is written by a thread of its own: no reader of it ends or holds up a tick."""

from __future__ import annotations

import errno
import os
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from queue import SimpleQueue
from typing import Any, cast

MOST = 10_000
"""Pieces of text that wait for a reader who does not read; what comes on top is lost."""

UNREAD = "words that nobody has read"
"""Name of a fault: who reads what is said has gone, or does not read."""

_GONE = (errno.EPIPE, errno.EIO)
"""Errors of a pipe that nobody reads any more, and of a terminal that has been closed."""


def give_up(stream: Any) -> None:
    """Nobody reads a stream any more: what is still said goes nowhere, and Python has nothing to flush."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


class Words:
    """Text on its way to who reads it.

    Attributes:
        lost: pieces that nobody has read.
    """

    def __init__(self) -> None:
        self.lost = 0
        # Whoever answers a signal may say something too: this queue is the one that may be put into there.
        self._waiting: SimpleQueue[tuple[Any, str] | None] = SimpleQueue()
        self._writer = threading.Thread(target=self._write, daemon=True)
        self._writer.start()

    def put(self, stream: Any, text: str) -> None:
        """Say a text on a stream, as soon as its reader takes it."""
        if self._waiting.qsize() < MOST:
            self._waiting.put((stream, text))
        else:
            self.lost += 1

    def close(self, patience: float | None) -> None:
        """Wait until all is written, for so long at most, s; what is left then is lost."""
        self._waiting.put(None)
        self._writer.join(patience)
        self.lost += self._waiting.qsize()

    def _write(self) -> None:
        while (said := self._waiting.get()) is not None:
            stream, text = said
            try:
                stream.write(text)
                stream.flush()
            except (OSError, ValueError) as error:
                self.lost += 1
                if isinstance(error, OSError) and error.errno in _GONE:
                    give_up(stream)


class _Stream:
    """Stands for a stream: takes its text, and is it in all else."""

    def __init__(self, stream: Any, put: Callable[[Any, str], None]) -> None:
        self._stream, self._put = stream, put

    def write(self, text: str) -> int:
        self._put(self._stream, text)
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        self.write("".join(lines))

    def flush(self) -> None:
        """Its writer does."""

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextmanager
def said_aside(patience: float | None = 1.0) -> Iterator[Words]:
    """Let a thread write what is said on standard output and error; it never waits, and never raises.

    Args:
        patience: how long the end waits until all is written, s; None for as long as it takes.
    """
    words = Words()
    out, err = (cast(Any, _Stream(stream, words.put)) for stream in (sys.stdout, sys.stderr))
    with redirect_stdout(out), redirect_stderr(err):
        try:
            yield words
        finally:
            words.close(patience)
