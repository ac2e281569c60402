"""Whether the master still answers: without it a flight goes on, but nobody new is found."""

from __future__ import annotations

import threading


class MasterWatch:
    """Asks the master once a second, in a thread of its own.

    Attributes:
        gone: how often it did not answer.
    """

    def __init__(self, every: float = 1.0) -> None:
        self.gone, self._every, self._end = 0, every, threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def _watch(self) -> None:
        import rosgraph

        while not self._end.wait(self._every):
            try:
                rosgraph.Master("/skylimb").getPid()
            except Exception:  # a socket's error, or one of the master's own
                self.gone += 1

    def close(self) -> None:
        """Stop asking."""
        self._end.set()
