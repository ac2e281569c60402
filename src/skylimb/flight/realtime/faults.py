"""How often each fault of a flight on the wall clock was met."""

from __future__ import annotations

import logging
from collections import Counter

_log = logging.getLogger(__name__)


class Faults(Counter[str]):
    """Counts of faults by name; the first of a kind is logged."""

    def note(self, who: str, what: str, times: int = 1, why: str = "") -> None:
        """Count a fault that `who` has met; `why` is logged, and not a part of what is counted."""
        if what not in self:
            _log.warning("%s: %s%s", who, what, why and f": {why}")
        self[what] += times
