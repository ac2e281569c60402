"""Whether the master still answers and knows us, and who else commands the robot."""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection
from typing import Any

from skylimb.apps.ros1.installation import answers


class MasterWatch:
    """Asks the master once a second, in a thread of its own.

    Args:
        commands: whole names of the topics on which nobody else may publish.
        name: our own.
        register: tells a master of all that we publish and subscribe to.
        every: s.

    Attributes:
        gone: how often it did not answer; a flight goes on without it, but nobody new is found.
        anew: how often it had been started anew, and registered us again: else nobody new would be heard.
        foreign: who else publishes on a command's topic, "node on topic"; None before the first answer. A
            node that was killed stays registered: where its address refuses a connection, it is nobody.
    """

    def __init__(
        self,
        commands: Collection[str],
        name: str,
        register: Callable[[Any], None] = lambda master: None,
        every: float = 1.0,
    ) -> None:
        self.gone, self.anew, self._every, self._end = 0, 0, every, threading.Event()
        self._commands, self._name, self._register = commands, name, register
        self.foreign: tuple[str, ...] | None = None
        self._ask()  # who commands a robot that flies already has to be known before it is taken over
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def _watch(self) -> None:
        while not self._end.wait(self._every):
            self._ask()

    def _ask(self) -> None:
        try:
            self._look()
        except Exception:  # a socket's error, or one of the master's own
            self.gone += 1

    def _look(self) -> None:
        import rosgraph

        master = rosgraph.Master(self._name)
        publishers = master.getSystemState()[0]
        if not any(self._name in nodes for _, nodes in publishers) and not self._end.is_set():
            self._register(master)
            self.anew += 1
        self.foreign = tuple(
            f"{node} on {topic}"
            for topic, nodes in publishers
            if topic in self._commands
            for node in nodes
            if node != self._name and answers(node) is not False
        )

    def close(self) -> None:
        """Stop asking."""
        self._end.set()
