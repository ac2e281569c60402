"""What arrives is sorted: orders, requests, missions, the battery; each sensor from one sender at a time."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable
from typing import Any

from skylimb.analysis.exchange.lab_topics import (
    ACK,
    BATTERY,
    FOREIGN,
    IMU,
    JOINT_STATES,
    MISSION,
    MOCAP,
    PWMS,
    SENSORS,
    SERVO_STATES,
)
from skylimb.analysis.exchange.messages import Joy
from skylimb.apps.ros.battery import percentage
from skylimb.apps.ros.limits import FlightLimits
from skylimb.apps.ros.messages import Arrived
from skylimb.apps.ros.radio import ordered, steered
from skylimb.apps.ros.states import ORDERED, Order
from skylimb.apps.ros.tick import Received, Request
from skylimb.flight.realtime.speaker import SILENT, Speaker

_SENSORS = frozenset(topic.name for topic in SENSORS)
_STREAMS = frozenset(topic.name for topic in (MOCAP, IMU, JOINT_STATES, SERVO_STATES))
SELDOM = 2.0
"""Seconds of silence of what says little: battery, acknowledgement, duties."""
_MOST_REQUESTS = 8
"""Requests that are looked at in a tick: the newest."""


class MessageSorter:
    """Sorts what arrives.

    Args:
        cells: of the battery, in series.
        sense: takes what a sensor says.
        limits: of what a radio's sticks ask for.
    """

    def __init__(
        self,
        cells: int,
        sense: Callable[[Arrived], None] = lambda arrived: None,
        limits: FlightLimits | None = None,
    ) -> None:
        self._cells, self._sense, self._limits = cells, sense, limits or FlightLimits()
        self._joy: Joy | None = None
        self._speakers: dict[str, Speaker] = {}
        self.counts: Counter[str] = Counter()

    def sort(self, arrived: Iterable[Arrived]) -> Received:
        """Everything that came, in its order."""
        orders, requests, said = list[Order](), list[Request](), dict[str, Any]()
        for one in arrived:
            if one.topic in ORDERED:
                orders.append(ORDERED[one.topic])
            elif one.topic in _SENSORS:
                said |= self._of_the_robot(one)
            elif isinstance(one.value, Joy):
                if not all(map(math.isfinite, one.value.axes)):
                    self.counts["axis of joy is no number"] += 1
                orders += ordered(self._joy, one.value, self._limits.pad)
                self._joy, asked = one.value, steered(one.value, self._limits)
                requests += [] if asked is None else [asked]
                said |= {"radio": one.at, "taken_over": asked is not None}
            elif one.topic in (MISSION.name, FOREIGN):
                said["mission" if one.topic == MISSION.name else "foreign"] = one.value
            elif isinstance(one.value, Request):
                requests.append(one.value)
        if len(requests) > _MOST_REQUESTS:
            self.counts["requests thrown away"] += len(requests) - _MOST_REQUESTS
        # A user's newest order stands for all alike before it.
        orders = list(dict.fromkeys(orders))
        return Received(tuple(orders), tuple(requests[-_MOST_REQUESTS:]), **said)

    def _of_the_robot(self, one: Arrived) -> dict[str, Any]:
        """What is received of a message of who is listened to; a sensor's is handed on."""
        silent = SILENT if one.topic in _STREAMS else SELDOM
        known = self._speakers.get(one.topic, Speaker())
        if not known.hears(one.sender, one.at, silent):
            self.counts[f"second publisher of {one.topic}"] += 1
            return {}
        self._speakers[one.topic] = now = known.after(one.sender, one.at, silent)
        if now.changes > known.changes:
            self.counts[f"another publisher of {one.topic} is listened to"] += 1
        if one.topic == ACK.name:
            return {"acknowledged": int(one.value)}
        elif one.topic == PWMS.name:
            return {"pwms": one.value}
        elif one.topic == BATTERY.name and self._cells:
            charge = percentage(float(one.value), self._cells)
            if math.isnan(charge):
                self.counts[f"battery voltage is none of {self._cells} cells"] += 1
                return {"battery": charge}
            return {"battery": charge, "volts": float(one.value)}
        else:
            self._sense(one)
        return {}
