"""What arrives is sorted: orders, wishes, missions, the battery; sensors from one sender only."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from skylimb.apps.ros1.battery import percentage
from skylimb.apps.ros1.messages import Joints, Nav, Path, Pose
from skylimb.apps.ros1.states import Order
from skylimb.apps.ros1.topics import ACK, BATTERY, MISSION, ORDERS, SENSORS
from skylimb.apps.ros1.wishes import Wish

_ORDERS = {topic.name: Order(topic.name.rpartition("/")[2]) for topic in ORDERS}
_SENSORS = frozenset(topic.name for topic in SENSORS)
_MOST_WISHES = 8
"""Wishes that are looked at in a tick: the newest."""


class Arrived(NamedTuple):
    """A message that has come.

    Attributes:
        topic: without the namespace.
        value: a plain message, number or word; None for one without content.
        sender: who published it.
        at: when it came, the pacer's time, s.
    """

    topic: str
    value: Any
    sender: str
    at: float


class Sorted(NamedTuple):
    """What came since the last tick, for the pilot."""

    orders: tuple[Order, ...]
    wishes: tuple[Wish, ...]
    mission: str
    acknowledged: int | None
    battery: float | None


class Desk:
    """Sorts what arrives.

    Args:
        cells: of the battery, in series.
        sense: is handed what a sensor says.
    """

    def __init__(self, cells: int, sense: Callable[[Arrived], None] = lambda arrived: None) -> None:
        self._cells, self._sense = cells, sense
        self._senders: dict[str, str] = {}
        self.counts: Counter[str] = Counter()

    def sort(self, arrived: Iterable[Arrived]) -> Sorted:
        """Everything that came, in its order."""
        orders, wishes, mission = list[Order](), list[Wish](), ""
        acknowledged: int | None = None
        battery: float | None = None
        for one in arrived:
            if one.topic in _ORDERS:
                orders.append(_ORDERS[one.topic])
            elif one.topic in _SENSORS:
                if self._senders.setdefault(one.topic, one.sender) != one.sender:
                    self.counts[f"second publisher of {one.topic}"] += 1
                elif one.topic == ACK.name:
                    acknowledged = int(one.value)
                elif one.topic == BATTERY.name:
                    charge = percentage(float(one.value), self._cells)
                    if math.isnan(charge):
                        self.counts["battery voltage is no number"] += 1
                    else:
                        battery = charge
                else:
                    self._sense(one)
            elif one.topic == MISSION.name:
                mission = str(one.value)
            elif isinstance(one.value, Pose | Path | Nav | Joints):
                wishes.append(one.value)
        if len(wishes) > _MOST_WISHES:
            self.counts["wishes thrown away"] += len(wishes) - _MOST_WISHES
        # A user's newest order stands for all alike before it.
        orders = list(dict.fromkeys(orders))
        return Sorted(tuple(orders), tuple(wishes[-_MOST_WISHES:]), mission, acknowledged, battery)
