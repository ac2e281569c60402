"""The way from the flight's loop to the bridge and back."""

from __future__ import annotations

from collections import Counter

from skylimb.apps.ros1.desk import Arrived
from skylimb.apps.ros1.outputs import Outgoing
from skylimb.apps.ros1.rim.bridge import Faults
from skylimb.apps.ros1.rim.pipe import Pipe


class BridgeCarrier:
    """Follows `Carrier` over a pipe.

    Args:
        pipe: to the bridge.
    """

    def __init__(self, pipe: Pipe) -> None:
        self._pipe, self._faults = pipe, Counter[str]()

    @property
    def closed(self) -> bool:
        """Whether the bridge is gone."""
        return self._pipe.closed

    def take(self) -> list[Arrived]:
        """What the bridge has sent."""
        found: list[Arrived] = []
        for batch in self._pipe.receive():
            if isinstance(batch, Faults):
                self._faults = Counter(batch.counts)
            else:
                found += batch
        return found

    def carry(self, messages: list[Outgoing]) -> None:
        """Send a batch."""
        if messages:
            self._pipe.send(messages)

    def faults(self) -> Counter[str]:
        """The bridge's, and what was lost on the way to it."""
        lost = Counter({"lost on the way to ROS": self._pipe.lost}) if self._pipe.lost else Counter[str]()
        return self._faults + lost
