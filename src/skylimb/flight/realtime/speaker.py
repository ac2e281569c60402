"""Who is listened to: one sender, until it has been silent for a while."""

from __future__ import annotations

import math
from collections.abc import Hashable
from typing import NamedTuple

SILENT = 0.2
"""Seconds of silence after which another sender is listened to: one that was started anew has another name
or port. It is less than what a robot flies without a pose, and more than any stream's usual gap."""


class Speaker(NamedTuple):
    """Who is listened to.

    Attributes:
        sender: of the last message that was listened to; None before the first one.
        at: when that came, s.
        turns: how often somebody began to speak: another sender, or the same one after a silence.
        changes: how often that was another sender than before.
    """

    sender: Hashable | None = None
    at: float = -math.inf
    turns: int = 0
    changes: int = 0

    def hears(self, sender: Hashable, at: float, silent: float = SILENT) -> bool:
        """Whether a sender is listened to at a time, s."""
        return sender == self.sender or at - self.at > silent

    def after(self, sender: Hashable, at: float, silent: float = SILENT) -> Speaker:
        """After a message that was listened to."""
        other = self.sender not in (None, sender)
        begins = other or at - self.at > silent
        return Speaker(sender, at, self.turns + begins, self.changes + other)
