"""Whether the master still answers, and who else commands the robot."""

from __future__ import annotations

import threading
from collections.abc import Collection


class MasterWatch:
    """Asks the master once a second, in a thread of its own.

    Args:
        commands: whole names of the topics on which nobody else may publish.
        name: our own.
        every: s.

    Attributes:
        gone: how often it did not answer; a flight goes on without it, but nobody new is found.
        foreign: who else publishes on a command's topic, "node on topic"; None before the first answer.
    """

    def __init__(self, commands: Collection[str], name: str, every: float = 1.0) -> None:
        self.gone, self._every, self._end = 0, every, threading.Event()
        self._commands, self._name = commands, name
        self.foreign: tuple[str, ...] | None = None
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def _watch(self) -> None:
        import rosgraph

        while not self._end.wait(self._every):
            try:
                publishers = rosgraph.Master("/skylimb").getSystemState()[0]
            except Exception:  # a socket's error, or one of the master's own
                self.gone += 1
            else:
                self.foreign = tuple(
                    f"{node} on {topic}"
                    for topic, nodes in publishers
                    if topic in self._commands
                    for node in nodes
                    if node != self._name
                )

    def close(self) -> None:
        """Stop asking."""
        self._end.set()
